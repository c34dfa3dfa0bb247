"""Mutations of real files against every reader: always a world or a clear error.

Run as a program for the long form: `python tests/world/fuzz.py 10000`.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from tolman.world import WorldFileError
from tolman.world.bitmaps import parse_bitmap
from tolman.world.maze import parse_maze
from tolman.world.rosmap import parse_ros_map
from tolman.world.webots import parse_webots
from tolman.world.worldfile import parse_world

PGM = b"P5\n# c\n8 6\n255\n" + bytes(range(48))
PLAIN_PGM = b"P2 4 2 15\n0 1 2 3 4 5 6 15\n"
ROS = b"image: map.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.1]\nnegate: 0\noccupied_thresh: 0.65\n"
MAZE = b"+---+---+\n| S     |\n+   +---+\n|       |\n+---+---+\n"
YAML = b"""tolman-world: 1
room: {size: [1, 1]}
boxes:
  - corners: [[0.2, 0.2], [0.5, 0.4]]
  - {at: [0.7, 0.7], size: [0.1, 0.1], angle: 45, color: [0.1, 0.2, 0.3], texture: t}
polygons: [{points: [[0.1, 0.7], [0.3, 0.7], [0.2, 0.9]]}]
starts: {right: [0.8, 0.057, 0]}
textures: {t: {pattern: checks, size: [4, 4]}}
"""
WBT = b"""#VRML_SIM R2023b utf8
RectangleArena { floorSize 1.5 1.5 }
DEF B WoodenBox { translation 0.3 0.2 0.05 size 0.2 0.1 0.1 rotation 0 0 1 0.5 }
Solid { translation -0.4 0.1 0.05 children [ Shape { geometry Cylinder { radius 0.08 height 0.1 } } USE B ] }
E-puck { translation 0 0 0 }
"""
ROOM = b"P5 12 12 255\n" + (b"\x00" * 12 + (b"\x00" + b"\xff" * 10 + b"\x00") * 10 + b"\x00" * 12)
WORDS = (
    b"{",
    b"}",
    b"[",
    b"]",
    b"-",
    b"1e309",
    b"nan",
    b"*a",
    b"&a",
    b"999999999",
    b"\x00",
    b"\xff",
    b": ",
    b"\n",
    b"'",
)


def as_text(data: bytes) -> str:
    return data.decode("utf-8", errors="replace")


def read_ros(data: bytes) -> object:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "map.pgm").write_bytes(ROOM)
        return parse_ros_map(as_text(data), "f", Path(folder), "f")


READERS: dict[str, tuple[bytes, Callable[[bytes], object]]] = {
    "yaml": (YAML, lambda data: parse_world(as_text(data), "f", "f")),
    "pgm": (PGM, lambda data: parse_bitmap(data, "f")),
    "plain-pgm": (PLAIN_PGM, lambda data: parse_bitmap(data, "f")),
    "ros": (ROS, read_ros),
    "maze": (MAZE, lambda data: parse_maze(as_text(data), "f", "f")),
    "wbt": (WBT, lambda data: parse_webots(as_text(data), "f", "f")),
}


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
        except Exception:
            sys.stderr.write(f"{name}, seed {seed}: {changed!r}\n")
            raise
    return True


if __name__ == "__main__":
    for kind in READERS:
        valid = sum(check(kind, number) for number in range(int(sys.argv[1])))
        sys.stdout.write(f"{kind}: {sys.argv[1]} mutations, {valid} still valid\n")
