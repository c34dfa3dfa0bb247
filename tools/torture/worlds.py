"""Stresses the readers of world files: `python -m tools.torture.worlds [MUTATIONS]`.

POSIX only; exit 1 on a fault. Each reader has a process of its own, whose memory is capped and which is
killed if one file takes too long. A mutated file must give a world, or one `WorldFileError` of one line.
"""

from __future__ import annotations

import argparse
import io
import json
import resource
import signal
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from tolman.world import WorldFileError
from tolman.world.formats.bitmaps import parse_bitmap
from tolman.world.formats.maze import parse_maze
from tolman.world.formats.rosmap import parse_ros_map
from tolman.world.formats.webots import parse_webots
from tolman.world.formats.worldfile import parse_world

from .children import in_child

MEMORY_LIMIT = 500 * 2**20
"""Bytes that a reader may take beyond what the interpreter holds."""
PATIENCE = 10
"""Seconds after which one file counts as a hang."""

YAML = b"""tolman-world: 1
room: {size: [1, 1]}
boxes:
  - corners: [[0.2, 0.2], [0.5, 0.4]]
  - {at: [0.7, 0.7], size: [0.1, 0.1], angle: 45, color: [0.1, 0.2, 0.3], texture: t}
polygons: [{points: [[0.1, 0.7], [0.3, 0.7], [0.2, 0.9]]}]
starts: {right: [0.8, 0.057, 0]}
textures: {t: {pattern: checks, size: [4, 4]}}
"""
PGM = b"P5\n# c\n8 6\n255\n" + bytes(range(48))
PLAIN_PGM = b"P2 4 2 15\n0 1 2 3 4 5 6 15\n"
ROS = b"image: map.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.1]\nnegate: 0\noccupied_thresh: 0.65\n"
ROOM = b"P5 12 12 255\n" + (b"\x00" * 12 + (b"\x00" + b"\xff" * 10 + b"\x00") * 10 + b"\x00" * 12)
MAZE = b"+---+---+\n| S     |\n+   +---+\n|       |\n+---+---+\n"
WBT = b"""#VRML_SIM R2023b utf8
RectangleArena { floorSize 1.5 1.5 }
DEF B WoodenBox { translation 0.3 0.2 0.05 size 0.2 0.1 0.1 rotation 0 0 1 0.5 }
Solid { translation -0.4 0.1 0.05 children [ Shape { geometry Cylinder { radius 0.08 height 0.1 } } USE B ] }
E-puck { translation 0 0 0 }
"""
WORDS = [b"{", b"}", b"[", b"]", b"-", b"1e309", b"nan", b"*a", b"&a", b"999999999", b"\x00", b"\xff"]
WORDS += [b": ", b"\n", b"'"]


def _text(data: bytes) -> str:
    return data.decode("utf-8", errors="replace")


def _ros(data: bytes, picture: bytes = ROOM) -> object:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "map.pgm").write_bytes(picture)
        return parse_ros_map(_text(data), "f", Path(folder), "f")


def _png() -> bytes:
    from PIL import Image

    picture = io.BytesIO()
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(6, 8)).save(picture, format="PNG")
    return picture.getvalue()


READERS: dict[str, tuple[bytes, Callable[[bytes], object]]] = {
    "yaml": (YAML, lambda data: parse_world(_text(data), "f", "f")),
    "pgm": (PGM, lambda data: parse_bitmap(data, "f")),
    "plain-pgm": (PLAIN_PGM, lambda data: parse_bitmap(data, "f")),
    "png": (_png(), lambda data: parse_bitmap(data, "f")),
    "ros": (ROS, _ros),
    "ros-image": (ROOM, lambda data: _ros(ROS, data)),
    "maze": (MAZE, lambda data: parse_maze(_text(data), "f", "f")),
    "wbt": (WBT, lambda data: parse_webots(_text(data), "f", "f")),
}
"""By name: a valid file, and what reads it."""


def mutated(data: bytes, random: np.random.Generator) -> bytes:
    """A few bytes changed, dropped, doubled or replaced by troublesome words."""
    for _ in range(int(random.integers(1, 6))):
        place = int(random.integers(0, len(data) + 1))
        end = min(len(data), place + int(random.integers(0, 12)))
        choice = int(random.integers(0, 5))
        if choice == 0:
            data = data[:place] + bytes(random.integers(0, 256, 1).tolist()) + data[place + 1 :]
        elif choice == 1:
            data = data[:place] + data[end:]
        elif choice == 2:
            data = data[:end] + data[place:]
        elif choice == 3:
            data = data[:place] + WORDS[int(random.integers(0, len(WORDS)))] + data[place:]
        else:
            data = data[:place] + WORDS[int(random.integers(0, len(WORDS)))] + data[end:]
    return data


def check(name: str, seed: int) -> bool:
    """Whether one mutation was still a valid file. Raises what a reader should not raise."""
    data, read = READERS[name]
    changed = mutated(data, np.random.default_rng(seed))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read(changed)
        except WorldFileError as error:
            if not str(error) or "\n" in str(error):
                raise ValueError(f"not one line: {error}") from None
            return False
    return True


def stress(name: str, mutations: int, tell: Callable[[bytes], object]) -> None:
    """Checks one reader in this process and tells what came of it: valid files, faults, bytes used.

    Before each file its seed is told, so that a death can be blamed on it. Memory is capped: what asks for
    more gets a MemoryError, a fault like any other exception.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)  # so that an alarm kills, also out of C code
    signal.alarm(PATIENCE)
    check(name, 0)
    before = _memory()
    resource.setrlimit(resource.RLIMIT_AS, (_address_space() + MEMORY_LIMIT, resource.RLIM_INFINITY))
    valid, faults = 0, []
    for seed in range(mutations):
        tell(f"{seed}\n".encode())
        signal.alarm(PATIENCE)
        try:
            valid += check(name, seed)
        except Exception as error:
            faults.append(f"{name}, seed {seed}: {type(error).__name__}: {error}")
    signal.alarm(0)
    tell(json.dumps([valid, faults, _memory() - before]).encode())


def _memory() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _address_space() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[0]) if Path("/proc/self/statm").exists() else 0
    return pages * resource.getpagesize() or 2**40


def campaign(name: str, mutations: int) -> tuple[int, list[str], int]:
    """(valid files, faults, bytes of memory used at most) of so many mutations for one reader."""
    told, killed = in_child(partial(stress, name, mutations))
    *seeds, last = told.decode().split("\n")
    if last:
        valid, faults, memory = json.loads(last)
        return valid, faults, memory
    died = "hung" if killed == signal.SIGALRM else f"died of signal {killed}"
    return 0, [f"{name}, seed {seeds[-1] if seeds else None}: {died}"], 0


def main() -> int:
    """Stresses every reader and prints what happened."""
    parser = argparse.ArgumentParser(prog="torture.worlds", description=__doc__)
    parser.add_argument("mutations", type=int, nargs="?", default=10_000)
    mutations: int = parser.parse_args().mutations
    wrong: list[str] = []
    for name in READERS:
        valid, faults, memory = campaign(name, mutations)
        wrong += faults
        print(
            f"{name}: {mutations} mutations, {valid} still valid, {len(faults)} faults, "
            f"{memory / 2**20:.0f} MB more at most",
            flush=True,
        )
    for fault in wrong[:20]:
        print(fault, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
