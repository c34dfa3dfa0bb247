"""Maps onto a disk that is full and into folders that cannot be written. POSIX only."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

from tolman.maps import HybridMap, MapError, MapFile, recover

from .children import in_child
from .maps import map_made_up_world


def full(folder: Path, sizes: range = range(150_000, 1_200_000, 70_000)) -> Counter[str]:
    """Maps while no file may grow beyond a size: one clear error, everything reported still there."""
    result: Counter[str] = Counter()
    for size in sizes:
        path = folder / f"full-{size}.tolman"
        number, _, text = in_child(partial(_map_on_full_disk, path, size))[0].decode().partition(" ")
        result["runs"] += 1
        result["ended with a clear error"] += text.startswith("clear")
        if text.startswith("unclear"):
            print(text, file=sys.stderr)
            result["unclear errors"] += 1
        if int(number) >= 0:
            found = HybridMap.load(path)
            result["nodes lost"] += sum(node not in found.graph for node in range(int(number) + 1))
            map_made_up_world(path, 12, 0, resume=True)
            result["resumed when there was room"] += 1
    return result


def _map_on_full_disk(path: Path, size: int, tell: Callable[[bytes], object]) -> None:
    """Maps where no file may grow beyond `size` bytes; tells the last node reported, and how it ended."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    saved = [-1]
    try:
        map_made_up_world(path, 12, 0, saved.append)
        text = "finished"
    except MapError as error:
        text = f"clear: {error}" if "\n" not in str(error) else "unclear"
    except BaseException as error:
        text = f"unclear: {error!r}"
    tell(f"{max(saved)} {text}".encode())


NOBODY = 65534
"""The user that root becomes, since root may write anywhere."""


def readonly(folder: Path) -> Counter[str]:
    """Tries every way of writing where nothing can be written: one clear line each, the map still reads."""
    shut = folder / "shut"
    shut.mkdir()
    sealed, growing = shut / "sealed.tolman", shut / "growing.tolman"
    map_made_up_world(sealed, 3, 0)
    whole = sealed.read_bytes()
    file = MapFile.create(growing)
    file.append(file.map, file.map.add_node())
    attempts: dict[str, Callable[[], object]] = {
        "create": lambda: MapFile.create(shut / "new.tolman"),
        "overwrite": lambda: MapFile.create(sealed, force=True),
        "resume": lambda: MapFile.resume(sealed),
        "save": lambda: HybridMap().save(shut / "new.tolman"),
        "save over": lambda: HybridMap().save(sealed, force=True),
        "recover": lambda: recover(sealed, shut / "new.tolman"),
    }
    told = _as_nobody(folder, shut, attempts, sealed)
    file.append(file.map, file.map.add_node())
    file.seal()
    result = Counter({"attempts": len(attempts), "nodes lost": 2 - len(HybridMap.load(growing).graph)})
    for name in attempts:
        text = told[name]
        clear = text.startswith("MapFileError: ") and "\n" not in text
        result["ended with a clear error"] += clear
        if not clear:
            print(f"{name}: {text}", file=sys.stderr)
            result["unclear errors"] += 1
    result["does not open"] = int(told["read"] != "3 nodes" or sealed.read_bytes() != whole)
    return result


def _as_nobody(
    folder: Path, shut: Path, attempts: dict[str, Callable[[], object]], sealed: Path
) -> dict[str, str]:
    """What each attempt ended with in a child that may read the folder but not write it."""

    def work(tell: Callable[[bytes], object]) -> None:
        if os.geteuid() == 0:
            os.setuid(NOBODY)
        told = {name: _ending(attempt) for name, attempt in attempts.items()}
        told["read"] = _ending(lambda: f"{len(HybridMap.load(sealed).graph)} nodes")
        tell(json.dumps(told).encode())

    folder.chmod(0o755)
    shut.chmod(0o555)
    text, _ = in_child(work)
    shut.chmod(0o755)
    found: dict[str, str] = json.loads(text)
    return found


def _ending(attempt: Callable[[], object]) -> str:
    try:
        return str(attempt())
    except BaseException as error:
        return f"{type(error).__name__}: {error}"
