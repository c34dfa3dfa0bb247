"""Straight walls from the cells of a map: outlines of an area, followed and straightened.

A wall that a map draws at a slant is a staircase of cells, and one seen through a noisy laser is ragged by a
cell or two. Neither is there: a map of cells says where a wall is to about a cell.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry import Point, signed_area

Mask = NDArray[np.bool_]
Corners = NDArray[np.float64]

_FITTED = 6
"""Steps of an edge from which on a line is fitted to them; one of fewer joins its corners."""
_CUT = 8.0
"""Cells of an edge that may be a corner cut off."""
_LEAST, _SHARE = 0.3, 0.3
"""Cells of tolerance from which on an outline is left as it is; by how much of its area it may change."""
_MITER = 0.45
"""Share of an edge that the slanted end of what stands for it may take."""


def outlines(area: Mask) -> list[Corners]:
    """The closed outlines of an area: (n, 2) corners of cells (column, row), the area on the left.

    Rows count upward here. The outline around the area runs counter-clockwise, those of its holes clockwise.
    Cells that touch at a corner alone do not hang together.
    """
    rows, columns = area.shape
    padded = np.pad(area, 1)
    leaving: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for dr, dc, start, step in (
        (-1, 0, (0, 0), (1, 0)),  # nothing below: rightwards along the lower edge
        (0, 1, (1, 0), (0, 1)),
        (1, 0, (1, 1), (-1, 0)),
        (0, -1, (0, 1), (0, -1)),
    ):
        beside = padded[1 + dr : 1 + dr + rows, 1 + dc : 1 + dc + columns]
        for row, column in np.argwhere(area & ~beside).tolist():
            begin = column + start[0], row + start[1]
            leaving.setdefault(begin, []).append((begin[0] + step[0], begin[1] + step[1]))
    found = []
    while leaving:
        first = next(iter(leaving))
        loop, here, before = [first], first, (0, 0)
        while True:
            ways = leaving[here]
            # Where two cells of the area touch at a corner, the sharper turn to the left stays with one.
            way = max(ways, key=lambda to: _turn(before, (to[0] - here[0], to[1] - here[1])))
            ways.remove(way)
            if not ways:
                del leaving[here]
            before, here = (way[0] - here[0], way[1] - here[1]), way
            if here == first:
                break
            loop.append(here)
        found.append(np.array(loop, dtype=np.float64))
    return found


def _turn(before: tuple[int, int], after: tuple[int, int]) -> int:
    return before[0] * after[1] - before[1] * after[0]


def straightened(loop: Corners, tolerance: float) -> list[Point]:
    """Few corners of an outline that keeps within about `tolerance` of a loop of unit steps.

    Douglas and Peucker (1973) finds the corners; each edge is then the line that fits its cells best, so that
    walls lie between the steps of a staircase, not on their tips. What is too small for that keeps its shape.
    """
    true = signed_area([(x, y) for x, y in loop.tolist()])
    while tolerance > _LEAST:
        points = _straightened(loop, tolerance)
        if len(points) >= 3 and abs(signed_area(points) - true) <= _SHARE * abs(true):
            return points
        tolerance *= 0.5
    turns = [
        k for k in range(len(loop)) if (loop[k] - loop[k - 1]) @ (loop[(k + 1) % len(loop)] - loop[k]) == 0.0
    ]
    return [(float(x), float(y)) for x, y in loop[turns]]


def _straightened(loop: Corners, tolerance: float) -> list[Point]:
    count = len(loop)
    # What is farthest from the middle, and what is farthest from that, are corners and not parts of walls.
    first = int(np.argmax(np.hypot(*(loop - loop.mean(axis=0)).T)))
    ring = np.roll(loop, -first, axis=0)
    closed = np.vstack((ring, ring[:1]))
    far = int(np.argmax(np.hypot(*(ring - ring[0]).T)))
    kept, todo = {0, far, count}, [(0, far), (far, count)]
    while todo:
        low, high = todo.pop()
        if high - low < 2:
            continue
        away = _distances(closed[low + 1 : high], closed[low], closed[high])
        worst = int(np.argmax(away))
        if away[worst] > tolerance:
            kept.add(low + 1 + worst)
            todo += [(low, low + 1 + worst), (low + 1 + worst, high)]
    corners = sorted(kept - {count})
    if len(corners) < 3:
        return []
    middles = 0.5 * (closed[:-1] + closed[1:])
    lines = []
    for low, high in zip(corners, (*corners[1:], corners[0] + count), strict=True):
        steps = np.arange(low, high) % count
        lines.append(_fit(middles[steps] if len(steps) >= _FITTED else ring[[low, high % count]]))
    met = [
        _meeting(lines[index - 1], lines[index], ring[corner], tolerance)
        for index, corner in enumerate(corners)
    ]
    return _sharpened([(float(x), float(y)) for x, y in met])


def _sharpened(points: list[Point]) -> list[Point]:
    """The outline with corners of the area where smoothing its cells has cut them off."""
    index = 0
    while index < len(points) > 4:
        a, b, c, d = (points[(index + k) % len(points)] for k in range(4))
        index += 1
        if math.dist(b, c) > _CUT or min(math.dist(a, b), math.dist(c, d)) <= _CUT:
            continue
        along, back = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
        cross = along[0] * back[1] - along[1] * back[0]
        if cross < 0.5 * math.hypot(*along) * math.hypot(*back):
            continue
        share = ((c[0] - a[0]) * back[1] - (c[1] - a[1]) * back[0]) / cross
        met = a[0] + share * along[0], a[1] + share * along[1]
        if share >= 1.0 and math.dist(met, b) <= _CUT and math.dist(met, c) <= _CUT:
            first, second = index % len(points), (index + 1) % len(points)
            points[first] = met
            del points[second]
    return points


def _distances(points: Corners, start: Corners, end: Corners) -> Corners:
    along = end - start
    length = math.hypot(*along)
    if length == 0.0:
        return np.asarray(np.hypot(*(points - start).T))
    offsets = points - start
    share = np.clip(offsets @ along / (length * length), 0.0, 1.0)
    return np.asarray(np.hypot(*(offsets - share[:, None] * along).T))


def _fit(points: Corners) -> tuple[Corners, Corners]:
    """Center and direction of the line that fits points best."""
    center = points.mean(axis=0)
    offsets = points - center
    _, vectors = np.linalg.eigh(offsets.T @ offsets)
    return center, vectors[:, -1]


def _meeting(
    line: tuple[Corners, Corners], other: tuple[Corners, Corners], corner: Corners, tolerance: float
) -> Corners:
    """Where two lines meet, if that is near the corner between them; else the corner itself."""
    (p, d), (q, e) = line, other
    cross = d[0] * e[1] - d[1] * e[0]
    if abs(cross) < 0.1:
        return corner
    share = ((q[0] - p[0]) * e[1] - (q[1] - p[1]) * e[0]) / cross
    met = p + share * d
    return met if math.hypot(*(met - corner)) <= tolerance else corner


def walls_along(points: Sequence[Point], thickness: float) -> list[tuple[Point, ...]]:
    """A quadrilateral for each edge of an outline, on its right, joined at their slanted ends."""
    count = len(points)
    inner = [_mitered(points[k - 1], points[k], points[(k + 1) % count], thickness) for k in range(count)]
    return [
        (points[k], inner[k], inner[(k + 1) % count], points[(k + 1) % count])
        for k in range(count)
        if points[k] != points[(k + 1) % count]
    ]


def _mitered(before: Point, corner: Point, after: Point, thickness: float) -> Point:
    first, second = math.dist(before, corner), math.dist(corner, after)
    if first == 0.0 or second == 0.0:
        return corner
    normal = (corner[1] - before[1]) / first, -(corner[0] - before[0]) / first
    other = (after[1] - corner[1]) / second, -(after[0] - corner[0]) / second
    x, y = normal[0] + other[0], normal[1] + other[1]
    length = math.hypot(x, y)
    if length < 1e-6:
        return corner
    # Long slanted ends, at sharp corners, are cut: they would stick out of the next edge.
    reach = min(2.0 * thickness / length, 2.0 * thickness, _MITER * min(first, second) * math.sqrt(2.0))
    return corner[0] + reach * x / length, corner[1] + reach * y / length
