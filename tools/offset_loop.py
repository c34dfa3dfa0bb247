"""The loop that a robot drives around the free space of a world of axis-parallel boxes."""

from __future__ import annotations

import numpy as np
from tolman.world.geometry import Plan
from tolman.world.spec import WorldSpec

Point = tuple[float, float]


def boundary_loops(spec: WorldSpec) -> list[list[Point]]:
    """Loops around the free space of a world of axis-parallel boxes, the free space on the left."""
    plan = Plan(spec.shapes)
    points = [point for outline in plan.outlines for point in outline]
    xs, ys = (sorted({round(point[axis], 9) for point in points}) for axis in (0, 1))
    middle_x, middle_y = (np.add(line[1:], line[:-1]) / 2 for line in (xs, ys))
    free = np.array([[not plan.contains(x, y) for y in middle_y] for x in middle_x])
    free = np.pad(free, 1)
    edges: dict[Point, Point] = {}
    for i in range(len(xs)):
        for j in range(len(ys)):
            if j + 1 < len(ys) and free[i, j + 1] != free[i + 1, j + 1]:
                low, high = (xs[i], ys[j]), (xs[i], ys[j + 1])
                edges.update({low: high} if free[i, j + 1] else {high: low})
            if i + 1 < len(xs) and free[i + 1, j] != free[i + 1, j + 1]:
                low, high = (xs[i], ys[j]), (xs[i + 1], ys[j])
                edges.update({low: high} if free[i + 1, j + 1] else {high: low})
    loops = []
    while edges:
        first, current = edges.popitem()
        loop = [first]
        while current != first:
            loop.append(current)
            current = edges.pop(current)
        loops.append(_without_straights(loop))
    return loops


def _without_straights(loop: list[Point]) -> list[Point]:
    kept = []
    for before, here, after in zip([loop[-1], *loop[:-1]], loop, [*loop[1:], loop[0]], strict=True):
        turn = (here[0] - before[0]) * (after[1] - here[1]) - (here[1] - before[1]) * (after[0] - here[0])
        if abs(turn) > 1e-12:
            kept.append(here)
    return kept


def offset(loop: list[Point], distance: float) -> list[Point]:
    """The corners of the same loop, moved into the free space by `distance` from both walls."""
    moved = []
    for before, here, after in zip([loop[-1], *loop[:-1]], loop, [*loop[1:], loop[0]], strict=True):
        arriving = np.sign(np.subtract(here, before).round(9))
        leaving = np.sign(np.subtract(after, here).round(9))
        left = np.array((-arriving[1] - leaving[1], arriving[0] + leaving[0]))
        x, y = np.array(here) + distance * left
        moved.append((float(x), float(y)))
    return moved


def arc_lengths(loop: list[Point]) -> list[float]:
    """Lengths (m) of the loop's edges."""
    return [float(np.hypot(*np.subtract(b, a))) for a, b in zip(loop, [*loop[1:], loop[0]], strict=True)]
