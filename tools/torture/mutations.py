"""Reads damaged and crafted map files in child processes, and counts how each ended. POSIX only."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
from tolman.maps import MapError

from .children import counted
from .maps import content_digest, map_made_up_world
from .mutants import MUTATIONS, mutate


def mutations(count: int, seed: int, folder: Path) -> Counter[str]:
    """Reads `count` damaged and crafted files in child processes, and counts how each ended."""
    source = folder / "source.tolman"
    map_made_up_world(source, 4, 1)
    truth = content_digest(source)
    return counted(count, lambda number: _one(source, truth, number, seed, folder))


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
