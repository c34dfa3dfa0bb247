"""Reads damaged and crafted map files in child processes, and counts how each ended. POSIX only."""

from __future__ import annotations

import resource
import signal
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from tolman.maps import MapError

from .children import in_child
from .maps import content_digest, map_made_up_world
from .mutants import MUTATIONS, mutate

MEMORY_LIMIT_MB = 500
PATIENCE = 30
"""Seconds after which one file counts as a hang."""


def mutations(count: int, seed: int, folder: Path) -> Counter[str]:
    """Reads `count` damaged and crafted files in child processes, and counts how each ended."""
    source = folder / "source.tolman"
    map_made_up_world(source, 4, 1)
    truth = content_digest(source)
    result: Counter[str] = Counter()
    done = 0
    while done < count:
        size = min(250, count - done)
        result += _batch(source, truth, range(done, done + size), seed, folder)
        done += size
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024
    result["peak memory of a reader, MB"] = peak
    result["over the memory limit"] = int(peak > MEMORY_LIMIT_MB)
    return result


def _batch(source: Path, truth: str, numbers: range, seed: int, folder: Path) -> Counter[str]:
    def work(tell: Callable[[bytes], object]) -> None:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)  # so that an alarm kills, also out of C code
        for number in numbers:
            signal.alarm(PATIENCE)
            tell(f"{_one(source, truth, number, seed, folder)}\n".encode())

    told, killed = in_child(work)
    result = Counter(line.strip() for line in told.decode().splitlines())
    if killed:
        result["hangs" if killed == signal.SIGALRM else "crashes"] += 1
    return result


def _one(source: Path, truth: str, number: int, seed: int, folder: Path) -> str:
    rng = np.random.default_rng([seed, number])
    path = folder / "mutant.tolman"
    name = MUTATIONS[number % len(MUTATIONS)]
    crafted = mutate(source, path, name, rng)
    try:
        digest = content_digest(path)
    except MapError as error:
        return "refused" if "\n" not in str(error) else f"more than one line: {name}"
    except Exception as error:
        return f"another exception: {name}: {type(error).__name__}: {error}"
    if digest == truth:
        return "loaded what it held"
    return f"crafted and loaded: {name}" if crafted else f"silently wrong: {name}"
