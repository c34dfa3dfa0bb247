"""Shapes as faces in three dimensions: what a ray can hit, and how each face looks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..geometry import Floats, Point, outline_segments

if TYPE_CHECKING:
    from ..spec import Shape

Ints = NDArray[np.int64]


class Faces:
    """The upright faces and the tops of shapes: faces 0..n-1 stand on the segments, the rest are tops.

    segments: (n, 4) m; heights: (n,) m of the shape of each; owners: (n,) index into `shapes`.
    """

    def __init__(self, shapes: Sequence[Shape], outlines: Sequence[Sequence[Point]] | None = None) -> None:
        """Builds the faces; `outlines` replaces the shapes' own (for bodies that have moved)."""
        self.shapes = tuple(shapes)
        self.outlines = tuple(map(tuple, outlines or (shape.outline() for shape in shapes)))
        self.segments: Floats = outline_segments(self.outlines)
        self.owners: Ints = np.repeat(np.arange(len(shapes)), [len(points) for points in self.outlines])
        tops = np.array([shape.height for shape in shapes], dtype=np.float64)
        self.tops: Floats = tops
        self.heights: Floats = tops[self.owners] if len(shapes) else np.zeros(0)

    @property
    def count(self) -> int:
        """How many faces there are."""
        return len(self.segments) + len(self.shapes)

    def normals(self) -> Floats:
        """Outward unit normals (count, 3); tops point up."""
        along = self.segments[:, 2:] - self.segments[:, :2]
        length = np.hypot(along[:, 0], along[:, 1])
        normals = np.zeros((self.count, 3))
        normals[: len(along), 0] = along[:, 1] / length
        normals[: len(along), 1] = -along[:, 0] / length
        normals[len(along) :, 2] = 1.0
        return normals

    def of_shapes(self, values: Floats) -> Floats:
        """Values (faces, ...) of the faces, given those (shapes, ...) of their shapes."""
        return np.concatenate((values[self.owners], values))

    def triangles(self) -> tuple[NDArray[np.float32], Ints]:
        """Corners (t, 3, 3) m of triangles that cover the faces, and the face (t,) of each."""
        x0, y0, x1, y1 = self.segments.T
        zero = np.zeros(len(x0))
        a, b = np.stack((x0, y0, zero), 1), np.stack((x1, y1, zero), 1)
        c, d = np.stack((x1, y1, self.heights), 1), np.stack((x0, y0, self.heights), 1)
        sides = np.stack((np.stack((a, b, c), 1), np.stack((a, c, d), 1)), 1).reshape(-1, 3, 3)
        faces = [np.repeat(np.arange(len(x0)), 2)]
        parts = [sides]
        for index, points in enumerate(self.outlines):
            cover = [[(*points[k], self.tops[index]) for k in corner] for corner in triangulate(points)]
            parts.append(np.array(cover, dtype=np.float64).reshape(-1, 3, 3))
            faces.append(np.full(len(cover), len(x0) + index))
        return np.concatenate(parts).astype(np.float32), np.concatenate(faces).astype(np.int64)


def triangulate(points: Sequence[Point]) -> list[tuple[int, int, int]]:
    """Triangles, as indices of corners, that cover a simple counter-clockwise polygon (ear clipping)."""
    left = list(range(len(points)))
    triangles: list[tuple[int, int, int]] = []
    while len(left) > 3:
        for k in range(len(left)):
            ear = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _is_ear(points, ear, left):
                triangles.append(ear)
                del left[k]
                break
        else:  # a polygon that crosses itself has no ear: cover what is left as a fan
            triangles += [(left[0], left[k], left[k + 1]) for k in range(1, len(left) - 1)]
            return triangles
    triangles.append((left[0], left[1], left[2]))
    return triangles


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _is_ear(points: Sequence[Point], ear: tuple[int, int, int], left: Sequence[int]) -> bool:
    a, b, c = (points[k] for k in ear)
    if _turn(a, b, c) <= 0:
        return False
    for k in left:
        p = points[k]
        if k not in ear and _turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0:
            return False
    return True
