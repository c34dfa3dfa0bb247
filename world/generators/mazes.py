"""Mazes of the micromouse kind: without loops, with loops, and of the contests' size."""

from __future__ import annotations

import numpy as np

from ..formats.maze import parse_maze
from ..spec import WorldSpec

Cell = tuple[int, int]
Doors = set[tuple[Cell, Cell]]


def tree_maze(rng: np.random.Generator) -> WorldSpec:
    """A maze of 4 x 4 to 7 x 7 cells in which there is one way from each cell to each other."""
    columns, rows = (int(size) for size in rng.integers(4, 8, 2))
    return _world(spanning_tree(columns, rows, rng), columns, rows, "a maze without loops")


def braided_maze(rng: np.random.Generator) -> WorldSpec:
    """A maze of 5 x 5 to 8 x 8 cells in which a third of the dead ends are opened: walls stand free."""
    columns, rows = (int(size) for size in rng.integers(5, 9, 2))
    doors = spanning_tree(columns, rows, rng)
    _open_dead_ends(doors, columns, rows, 0.6, rng)
    return _world(doors, columns, rows, "a maze with loops")


def contest_maze(rng: np.random.Generator) -> WorldSpec:
    """16 x 16 cells, the start in a corner, four open cells in the middle, most dead ends opened."""
    side = 16
    doors = spanning_tree(side, side, rng)
    _open_dead_ends(doors, side, side, 0.5, rng)
    middle = [(x, y) for x in (side // 2 - 1, side // 2) for y in (side // 2 - 1, side // 2)]
    for one in middle:
        doors.update(_door(one, other) for other in middle if _beside(one, other))
    return _world(doors, side, side, "a maze of the contests' size")


def spanning_tree(columns: int, rows: int, rng: np.random.Generator) -> Doors:
    """The doors of a spanning tree of the cells, by a walk that backs up where it is stuck."""
    doors: Doors = set()
    seen, path = {(0, 0)}, [(0, 0)]
    while path:
        free = [cell for cell in _around(path[-1], columns, rows) if cell not in seen]
        if not free:
            path.pop()
            continue
        cell = free[int(rng.integers(len(free)))]
        doors.add(_door(path[-1], cell))
        seen.add(cell)
        path.append(cell)
    return doors


def _open_dead_ends(doors: Doors, columns: int, rows: int, share: float, rng: np.random.Generator) -> None:
    """Opens one more wall of a share of the cells that have one door, but for the start."""
    for x in range(columns):
        for y in range(rows):
            cell = (x, y)
            around = _around(cell, columns, rows)
            shut = [other for other in around if _door(cell, other) not in doors]
            if len(around) - len(shut) == 1 and cell != (0, 0) and rng.random() < share:
                doors.add(_door(cell, shut[int(rng.integers(len(shut)))]))


def _around(cell: Cell, columns: int, rows: int) -> list[Cell]:
    x, y = cell
    beside = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
    return [(u, v) for u, v in beside if 0 <= u < columns and 0 <= v < rows]


def _beside(one: Cell, other: Cell) -> bool:
    return abs(one[0] - other[0]) + abs(one[1] - other[1]) == 1


def _door(one: Cell, other: Cell) -> tuple[Cell, Cell]:
    return (one, other) if one < other else (other, one)


def _world(doors: Doors, columns: int, rows: int, description: str) -> WorldSpec:
    """Cell (0, 0), the start, is at the lower left."""
    lines = ["+" + "---+" * columns]
    for y in reversed(range(rows)):
        cells = ""
        for x in range(columns):
            mark = " S " if (x, y) == (0, 0) else "   "
            cells += mark + (" " if ((x, y), (x + 1, y)) in doors else "|")
        posts = "".join(("   " if ((x, y - 1), (x, y)) in doors else "---") + "+" for x in range(columns))
        lines += ["|" + cells, "+" + posts]
    spec = parse_maze("\n".join(lines), "a drawn maze", "maze")
    return WorldSpec(spec.name, spec.shapes, spec.starts, description=description)
