"""Rooms drawn from a seed, for experiments in worlds that nobody has looked at."""

from __future__ import annotations

import math

import numpy as np

from ....world.errors import WorldError
from ....world.formats.maze import parse_maze
from ....world.generators.mazes import spanning_tree
from ....world.spec import Box, Shape, WorldSpec, room_walls
from ....world.starts import with_starts
from ....world.transforms import rotated

LEAST_WALL, LEAST_GAP = 0.18, 0.24
"""Meters: the shortest wall, and the narrowest passage, of a drawn room."""
_GRID = 0.02
_TRIES = 1000
KINDS = ("blocks", "turned blocks", "maze")


def random_room(seed: int) -> WorldSpec:
    """The room of a seed: blocks at the walls, the same turned by any angle, or a maze, in turn.

    Everything hangs together with the outer wall, so that one round along the boundary meets all of it.
    """
    kind = KINDS[seed % len(KINDS)]
    rng = np.random.default_rng(np.random.SeedSequence([seed, 23]))
    if kind == "maze":
        return _maze(seed, rng)
    spec = _blocks(seed, rng)
    return spec if kind == "blocks" else rotated(spec, float(rng.uniform(0.0, math.tau)))


def _blocks(seed: int, rng: np.random.Generator) -> WorldSpec:
    for _ in range(_TRIES):
        width, depth = (_on_grid(rng.uniform(0.9, 1.5)) for _ in range(2))
        boxes: list[tuple[float, float, float, float]] = []
        for _ in range(int(rng.integers(2, 6))):
            box = _box(width, depth, rng)
            if all(_apart(box, other) for other in boxes):
                boxes.append(box)
        shapes: list[Shape] = [*room_walls(width, depth)]
        shapes += [Box((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0) for x0, y0, x1, y1 in boxes]
        spec = with_starts(WorldSpec(f"room {seed}", tuple(shapes), description="drawn from a seed"))
        if boxes and spec.starts:
            return spec
    raise WorldError(f"no room for seed {seed} in {_TRIES} tries")


def _box(width: float, depth: float, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """A box against one wall or in a corner: x0, y0, x1, y1 (m)."""
    across, out = _on_grid(rng.uniform(LEAST_WALL, 0.4)), _on_grid(rng.uniform(LEAST_WALL, 0.5))
    room, reach = (width, depth) if (upright := bool(rng.integers(2))) else (depth, width)
    out = min(out, _on_grid(reach - LEAST_GAP - 0.02))
    free = room - across
    low = 0.0 if rng.random() < 0.3 else _on_grid(rng.uniform(LEAST_GAP, max(LEAST_GAP, free - LEAST_GAP)))
    far = bool(rng.integers(2))
    near, away = (reach - out, reach) if far else (0.0, out)
    return (low, near, low + across, away) if upright else (near, low, away, low + across)


def _apart(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    """Whether a robot passes between two boxes."""
    dx = max(one[0] - other[2], other[0] - one[2])
    dy = max(one[1] - other[3], other[1] - one[3])
    return max(dx, dy) >= LEAST_GAP


def _on_grid(value: float) -> float:
    return round(round(value / _GRID) * _GRID, 6)


def _maze(seed: int, rng: np.random.Generator) -> WorldSpec:
    """A maze without loops, its cells as wide as two of the classic contest."""
    columns, rows = (int(value) for value in rng.integers(3, 5, size=2))
    doors = spanning_tree(columns, rows, rng)
    lines = ["+" + "---+" * columns]
    for y in range(rows):
        cells = ["   " + (" " if ((x, y), (x + 1, y)) in doors else "|") for x in range(columns)]
        posts = [("   " if ((x, y), (x, y + 1)) in doors else "---") + "+" for x in range(columns)]
        lines += ["|" + "".join(cells), "+" + "".join(posts)]
    return parse_maze("\n".join(lines), f"seed {seed}", f"maze {seed}", 2.0)
