"""The floor as cells: where a robot's center can be, and how far it is from there to elsewhere."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...world.geometry import Point
from ...world.robot import EPUCK
from ...world.spec import Shape, WorldSpec

Mask = NDArray[np.bool_]
Points = NDArray[np.float64]
Steps = NDArray[np.int64]

CELL = 0.01
"""Side (m) of a cell, unless the world has more than MOST_CELLS of them."""
MOST_CELLS = 4_000_000
_STRAIGHT, _DIAGONAL = 10, 14
"""Lengths of steps to neighboring cells, in tenths of a cell."""
_STEPS = tuple(
    (dr, dc, _STRAIGHT if 0 in (dr, dc) else _DIAGONAL)
    for dr in (-1, 0, 1)
    for dc in (-1, 0, 1)
    if (dr, dc) != (0, 0)
)
_FAR = np.iinfo(np.int64).max


@dataclass(frozen=True)
class Floor:
    """Cells of a world (row 0 lowest). free: whether a disc of the robot's size fits with its center there.

    origin: x, y (m) of the middle of cell (0, 0). cell: side, m.
    """

    free: Mask
    origin: Point
    cell: float

    @classmethod
    def of(cls, spec: WorldSpec, margin: float = 0.0, cell: float = CELL) -> Floor:
        """The floor of a world for a disc as wide as the robot and `margin` (m)."""
        outlines = [np.array(shape.outline()) for shape in spec.shapes]
        low = np.min([outline.min(axis=0) for outline in outlines], axis=0)
        high = np.max([outline.max(axis=0) for outline in outlines], axis=0)
        cell = max(cell, math.sqrt(float(np.prod(high - low + 2 * cell)) / MOST_CELLS))
        columns, rows = (int(count) for count in np.ceil((high - low) / cell).astype(int) + 1)
        free: Mask = np.ones((rows, columns), dtype=np.bool_)
        floor = cls(free, (float(low[0]), float(low[1])), cell)
        for shape in spec.shapes:
            floor._block(shape, EPUCK.body_radius + margin)
        return floor

    def _block(self, shape: Shape, radius: float) -> None:
        """Takes away the cells that are in a shape or nearer to it than `radius` (m)."""
        outline = np.array(shape.outline())
        low = np.floor((outline.min(axis=0) - radius - self.origin) / self.cell).astype(int)
        high = np.ceil((outline.max(axis=0) + radius - self.origin) / self.cell).astype(int)
        (c0, r0), (c1, r1) = np.maximum(low, 0), np.maximum(high, 0) + 1
        window = self.free[r0:r1, c0:c1]
        if window.size == 0:
            return
        rows, columns = np.mgrid[r0 : r0 + window.shape[0], c0 : c0 + window.shape[1]]
        x, y = self.origin[0] + columns * self.cell, self.origin[1] + rows * self.cell
        inside = np.zeros(window.shape, dtype=np.bool_)
        near = np.zeros(window.shape, dtype=np.bool_)
        for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            dx, dy = bx - ax, by - ay
            share = np.clip(((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-18), 0.0, 1.0)
            near |= (x - ax - share * dx) ** 2 + (y - ay - share * dy) ** 2 < radius * radius
            if ay != by:
                inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) * dx / dy)
        window &= ~(inside | near)

    def index(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell at a place (m), within the floor."""
        row, column = round((y - self.origin[1]) / self.cell), round((x - self.origin[0]) / self.cell)
        return min(max(row, 0), self.free.shape[0] - 1), min(max(column, 0), self.free.shape[1] - 1)

    def places(self, mask: Mask) -> Points:
        """(n, 2) m: the middles of the cells of a mask."""
        rows, columns = np.nonzero(mask)
        return np.stack((self.origin[0] + columns * self.cell, self.origin[1] + rows * self.cell), 1)

    def near(self, points: Points, radius: float) -> Mask:
        """The cells whose middles are within `radius` (m) of any of the points (n, 2) m."""
        found: Mask = np.zeros_like(self.free)
        reach = math.ceil(radius / self.cell)
        grid = np.arange(-reach, reach + 1)
        disc = np.argwhere(grid[:, None] ** 2 + grid[None, :] ** 2 <= (radius / self.cell) ** 2) - reach
        cells = np.unique(np.rint((points - self.origin) / self.cell).astype(int), axis=0)
        for row, column in disc:
            r, c = cells[:, 1] + row, cells[:, 0] + column
            kept = (r >= 0) & (r < found.shape[0]) & (c >= 0) & (c < found.shape[1])
            found[r[kept], c[kept]] = True
        return found

    def distances(self, x: float, y: float) -> NDArray[np.int64]:
        """Steps from a place (m) to each cell, in tenths of a cell along eight directions; -1: not reachable.

        Cells of one distance are taken together (Dial 1969), so that a large floor takes moments.
        """
        found: Steps = np.full(self.free.shape, _FAR, dtype=np.int64)
        height, width = self.free.shape
        start = self.nearest_free(*self.index(x, y))
        if start is None:
            return np.full(self.free.shape, -1, dtype=np.int64)
        found[start] = 0
        waiting: dict[int, list[NDArray[np.int64]]] = {0: [np.array([start])]}
        while waiting:
            at = min(waiting)
            cells = np.concatenate(waiting.pop(at))
            cells = cells[found[cells[:, 0], cells[:, 1]] == at]
            for dr, dc, length in _STEPS:
                rows, columns = cells[:, 0] + dr, cells[:, 1] + dc
                kept = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
                rows, columns = rows[kept], columns[kept]
                better = self.free[rows, columns] & (found[rows, columns] > at + length)
                rows, columns = rows[better], columns[better]
                if len(rows):
                    found[rows, columns] = at + length
                    waiting.setdefault(at + length, []).append(np.stack((rows, columns), 1))
        found[found == _FAR] = -1
        return found

    def nearest_free(self, row: int, column: int, within: int = 5) -> tuple[int, int] | None:
        """The free cell nearest to one, at most `within` cells away: a start stands beside a wall."""
        r0, c0 = max(0, row - within), max(0, column - within)
        cells = np.argwhere(self.free[r0 : row + within + 1, c0 : column + within + 1]) + np.array((r0, c0))
        if len(cells) == 0:
            return None
        best = cells[np.argmin(((cells - (row, column)) ** 2).sum(axis=1))]
        return int(best[0]), int(best[1])

    def reachable(self, x: float, y: float) -> Mask:
        """The cells that a robot's center can get to from a place (m)."""
        return self.distances(x, y) >= 0


def shortest(floor: Floor, start: Point, goal: Point) -> float | None:
    """Length (m) of the shortest way of the disc between two places, to about 1 %; None if there is none.

    A way over cells is pulled straight: it turns only where walls make it.
    """
    steps = floor.distances(*goal)
    here = floor.nearest_free(*floor.index(*start))
    if here is None or steps[here] < 0:
        return None
    way = [here]
    while steps[here] > 0:
        r, c = here
        beside = [(r + dr, c + dc) for dr, dc, _ in _STEPS]
        known = [each for each in beside if _inside(steps, each) and steps[each] >= 0]
        here = min(known, key=lambda each: int(steps[each]))
        way.append(here)
    return _pulled(floor, way)


def _inside(cells: Steps, at: tuple[int, int]) -> bool:
    rows, columns = cells.shape
    return bool(0 <= at[0] < rows and 0 <= at[1] < columns)


def _pulled(floor: Floor, way: list[tuple[int, int]]) -> float:
    """Length (m) of a way over cells after each stretch that can be seen along was made straight."""
    length, at = 0.0, 0
    while at < len(way) - 1:
        ahead = len(way) - 1
        while ahead > at + 1 and not _is_open(floor.free, way[at], way[ahead]):
            ahead = at + (ahead - at) // 2 if ahead - at > 8 else ahead - 1
        while ahead < len(way) - 1 and _is_open(floor.free, way[at], way[ahead + 1]):
            ahead += 1
        length += math.dist(way[at], way[ahead])
        at = ahead
    return length * floor.cell


def _is_open(free: Mask, one: tuple[int, int], other: tuple[int, int]) -> bool:
    count = 2 * max(abs(one[0] - other[0]), abs(one[1] - other[1])) + 1
    rows = np.rint(np.linspace(one[0], other[0], count)).astype(int)
    columns = np.rint(np.linspace(one[1], other[1], count)).astype(int)
    return bool(np.all(free[rows, columns]))
