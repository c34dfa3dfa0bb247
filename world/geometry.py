"""Outlines and segments: what both ray casters, both simulators and the importers measure with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Point: TypeAlias = tuple[float, float]
"""x, y in m."""
Floats = NDArray[np.float64]
Edge = tuple[float, float, float, float, float]
"""Start x, y, way to the end along x, y (m), and its length squared."""
FACETS = 48
"""Sides of the prism that stands for a cylinder in every sensor; a 5 cm radius is off by 0.1 mm at most."""


def rectangle(x: float, y: float, width: float, depth: float, angle: float = 0.0) -> tuple[Point, ...]:
    """The four corners (m), counter-clockwise, of a rectangle around (x, y) turned by `angle`."""
    half_width, half_depth = width / 2, depth / 2
    corners = (
        (-half_width, -half_depth),
        (half_width, -half_depth),
        (half_width, half_depth),
        (-half_width, half_depth),
    )
    if angle == 0.0:
        return tuple((x + u, y + v) for u, v in corners)
    cosine, sine = math.cos(angle), math.sin(angle)
    return tuple((x + cosine * u - sine * v, y + sine * u + cosine * v) for u, v in corners)


def disk(x: float, y: float, radius: float, facets: int = FACETS) -> tuple[Point, ...]:
    """Corners (m), counter-clockwise, of the regular polygon inscribed in a circle."""
    turns = [math.tau * k / facets for k in range(facets)]
    return tuple((x + radius * math.cos(turn), y + radius * math.sin(turn)) for turn in turns)


def signed_area(points: Sequence[Point]) -> float:
    """Area (m^2) of a polygon, positive when its points run counter-clockwise."""
    total = 0.0
    for (x0, y0), (x1, y1) in zip(points, (*points[1:], points[0]), strict=True):
        total += x0 * y1 - x1 * y0
    return total / 2


def outline_segments(outlines: Iterable[Sequence[Point]]) -> Floats:
    """All edges of the outlines: (n, 4) rows of x0, y0, x1, y1 (m), solid on the left."""
    rows = [
        (*start, *end)
        for points in outlines
        for start, end in zip(points, (*points[1:], points[0]), strict=True)
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 4)


def _same(angle: float) -> float:
    return angle


@dataclass(frozen=True, slots=True)
class Similarity:
    """A map of the floor onto itself: of points (m), headings and boxes' angles (rad), and lengths."""

    point: Callable[[Point], Point]
    heading: Callable[[float], float] = _same
    angle: Callable[[float], float] = _same
    scale: float = 1.0
    mirrors: bool = False


class Upright(Protocol):
    """What stands on the floor: all that a plan needs to know of a shape."""

    @property
    def height(self) -> float:
        """Meters above the floor."""

    def outline(self) -> tuple[Point, ...]:
        """Corners (m) on the floor, counter-clockwise."""


class Plan:
    """The floor plan of a set of shapes: distances, insides, and what is near a place.

    shapes: in the order of the world's description. `segments`: (n, 4) m, all edges; `owners`: (n,) the index
    of the shape that each belongs to.
    """

    CELL = 0.05
    """Side (m) of the squares that the edges are sorted into; in a first sorting they are 8 times as wide."""
    REMEMBERED = 20_000
    """How many squares are remembered before all are forgotten, so that no run grows without end."""

    def __init__(self, shapes: Sequence[Upright], min_height: float = 0.0) -> None:
        """Takes in the shapes that are at least `min_height` (m) high."""
        kept = [(index, shape) for index, shape in enumerate(shapes) if shape.height >= min_height]
        self.outlines = tuple(shape.outline() for _, shape in kept)
        self.indices = tuple(index for index, _ in kept)
        self.segments = outline_segments(self.outlines)
        self.owners = np.repeat(np.arange(len(kept)), [len(points) for points in self.outlines])
        self._wide_cells: dict[tuple[int, int, float], NDArray[np.intp]] = {}
        self._edges: dict[tuple[int, int, float], list[Edge]] = {}

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x0, y0, x1, y1) m of everything; all zero for an empty plan."""
        if not len(self.segments):
            return 0.0, 0.0, 0.0, 0.0
        xs, ys = self.segments[:, 0::2], self.segments[:, 1::2]
        return float(xs.min()), float(ys.min()), float(xs.max()), float(ys.max())

    def _reached(
        self, candidates: NDArray[np.intp], column: int, row: int, side: float, reach: float
    ) -> NDArray[np.intp]:
        center = (column + 0.5) * side, (row + 0.5) * side
        distances = point_segment_distances(*center, self.segments[candidates])
        return candidates[distances <= reach + side * math.sqrt(0.5)]

    def _near(self, column: int, row: int, reach: float) -> NDArray[np.intp]:
        """Indices of at least all segments closer than `reach` (m) to any point of a square."""
        wide = column // 8, row // 8, reach
        candidates = self._wide_cells.get(wide)
        if candidates is None:
            if len(self._wide_cells) >= self.REMEMBERED:
                self._wide_cells.clear()
            every = np.arange(len(self.segments))
            candidates = self._wide_cells[wide] = self._reached(every, *wide[:2], 8 * self.CELL, reach)
        return self._reached(candidates, column, row, self.CELL, reach)

    def gaps(self, x: float, y: float, radius: float) -> list[tuple[float, float, float]]:
        """Edges nearer than `radius` (m) to a point: (distance, nx, ny), n the unit vector away from each."""
        found = []
        for x0, y0, along_x, along_y, length2 in self.edges_near(x, y, radius):
            share = ((x - x0) * along_x + (y - y0) * along_y) / length2
            share = 0.0 if share < 0.0 else 1.0 if share > 1.0 else share
            away_x, away_y = x - x0 - share * along_x, y - y0 - share * along_y
            distance = math.hypot(away_x, away_y)
            if distance < radius:
                scale = 1.0 / distance if distance > 0.0 else 0.0
                found.append((distance, away_x * scale, away_y * scale))
        return found

    def edges_near(self, x: float, y: float, radius: float) -> list[Edge]:
        """At least all edges nearer than `radius` (m) to a point; remembered by square."""
        column, row = math.floor(x / self.CELL), math.floor(y / self.CELL)
        key = column, row, radius
        edges = self._edges.get(key)
        if edges is None:
            if len(self._edges) >= self.REMEMBERED:
                self._edges.clear()
            edges = self._edges[key] = edges_of(self.segments[self._near(column, row, radius)])
        return edges

    def contains(self, x: float, y: float) -> bool:
        """Whether a point is inside any of the shapes (on an edge either answer is right)."""
        if not len(self.segments):
            return False
        x0, y0, x1, y1 = self.segments.T
        with np.errstate(divide="ignore", invalid="ignore"):
            crosses = ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return bool((np.bincount(self.owners, weights=crosses) % 2 == 1).any())

    def clearance(self, x: float, y: float) -> float:
        """Distance (m) to the nearest edge, negative inside a shape; inf when there are no shapes."""
        if not len(self.segments):
            return math.inf
        distance = float(point_segment_distances(x, y, self.segments).min())
        return -distance if self.contains(x, y) else distance


def edges_of(segments: Floats) -> list[Edge]:
    """Segments (n, 4) m as edges."""
    return [
        (x0, y0, x1 - x0, y1 - y0, max((x1 - x0) ** 2 + (y1 - y0) ** 2, 1e-30))
        for x0, y0, x1, y1 in segments.tolist()
    ]


class Clearing:
    """A disk around a moving point that no edge of a plan reaches into: inside it nothing need be asked."""

    def __init__(self, plan: Plan, reach: float, look_ahead: float) -> None:
        """reach: how near (m) an edge counts; look_ahead: how far (m) beyond it is looked at most."""
        self._plan, self._reach, self._look_ahead = plan, reach, look_ahead
        self._x = self._y = self._room = 0.0

    def holds(self, x: float, y: float) -> bool:
        """Whether it is known from before that no edge is within reach of (x, y) m."""
        return (x - self._x) ** 2 + (y - self._y) ** 2 < self._room

    def renew(self, x: float, y: float) -> bool:
        """Measures again, around (x, y) m; whether no edge is within reach there."""
        gaps = self._plan.gaps(x, y, self._reach + self._look_ahead)
        room = min(gaps)[0] - self._reach if gaps else self._look_ahead
        self._x, self._y, self._room = x, y, room * room if room > 0.0 else 0.0
        return room >= 0.0


def point_segment_distances(x: float, y: float, segments: Floats) -> Floats:
    """Distances (n,) m from one point to each of the segments (n, 4)."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    offset = np.array((x, y)) - start
    length2 = np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
    share = np.clip(np.einsum("ij,ij->i", offset, along) / length2, 0.0, 1.0)
    rest = offset - share[:, None] * along
    distances: Floats = np.sqrt(np.einsum("ij,ij->i", rest, rest))
    return distances


def cast(origins: Floats, directions: Floats, segments: Floats) -> Floats:
    """Distances (n,) m along rays to the first segment met, inf where none is.

    origins, directions: (n, 2) m and unit vectors; segments: (m, 4) m. Both faces of an edge stop a ray.
    """
    if not len(segments):
        return np.full(len(origins), np.inf)
    along_x, along_y = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    ray_x, ray_y = directions[:, :1], directions[:, 1:]
    off_x, off_y = segments[:, 0] - origins[:, :1], segments[:, 1] - origins[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / (ray_x * along_y - ray_y * along_x)
        distance = (off_x * along_y - off_y * along_x) * inverse
        share = (off_x * ray_y - off_y * ray_x) * inverse
        hit = (distance >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)
    nearest: Floats = np.where(hit, distance, np.inf).min(axis=1)
    return nearest
