"""Where the mapped boundaries lie in the map frame, and the straight ways between them.

An outline is the path of the robot's center along one boundary: its corners are the nodes, edge k leads from
node k to the next. Wall following makes arcs' lengths and turns good enough to lay it out by dead reckoning;
what is missing when it comes round is spread over turns, then over lengths.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from ...maps.boundary.layout import place_in
from ...maps.boundary.walk import close_polygon, onward, walk
from ...world.robot import Pose
from ..boundary.trace import BoundaryTrace, Corner

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap

Point = tuple[float, float]
_QUARTER = 0.5 * math.pi
SLANT = 0.5
"""Sine of the least angle between a wall and the way that leaves it."""
_ROOM = {"concave": (0.03, 0.02), "convex": (0.14, 0.085)}
"""Along an edge (m): the first place to set out from after a corner, and how far before one the last is."""


@dataclass(frozen=True, slots=True)
class Outline:
    """A closed boundary in the map frame. points (m), nodes, corners: one a corner; unmapped: points."""

    points: tuple[Point, ...]
    nodes: tuple[int, ...] = ()
    corners: tuple[str, ...] = ()

    def edge(self, index: int) -> tuple[Point, Point]:
        """Both ends of the edge that leaves corner `index`."""
        return self.points[index], self.points[(index + 1) % len(self.points)]

    def direction(self, index: int) -> float:
        """Heading (rad) of the edge that leaves corner `index`."""
        (x0, y0), (x1, y1) = self.edge(index)
        return math.atan2(y1 - y0, x1 - x0)

    def length(self, index: int) -> float:
        """Length (m) of the edge that leaves corner `index`."""
        return math.dist(*self.edge(index))

    @property
    def turning(self) -> float:
        """+1 if it runs counter-clockwise, -1 if clockwise."""
        return math.copysign(1.0, signed_area(self.points))

    @property
    def middle(self) -> Point:
        """Mean of its corners (m)."""
        count = len(self.points)
        return math.fsum(x for x, _ in self.points) / count, math.fsum(y for _, y in self.points) / count

    def distance(self, x: float, y: float) -> float:
        """Distance (m) of a point from the outline."""
        return min(to_segment((x, y), *self.edge(index))[0] for index in range(len(self.points)))

    def leave_range(self, edge: int) -> tuple[float, float]:
        """From where to where (m along it) an edge may be left across open space."""
        first, last = self.corners[edge], self.corners[(edge + 1) % len(self.corners)]
        low = _ROOM.get(first, _ROOM["convex"])[0]
        return low, self.length(edge) - _ROOM.get(last, _ROOM["convex"])[1]


def outline_from(hybrid: HybridMap, first: int) -> Outline | None:
    """The outline of the boundary that `first` is on, from the side mapped with; None if it is not closed."""
    way = walk(onward(hybrid, hybrid.meta.side), first)
    if not way.closed:
        return None
    data = [hybrid.graph.nodes[node] for node in way.nodes]
    x, y = place_in(data[0]["notes"]) or (0.0, 0.0)
    corners = [str(entry["corner"]) for entry in data]
    turns = [float(entry["turn"]) for entry in data]
    points = closed_points(corners, turns, way.lengths, Pose(x, y, data[0]["entry_heading"]))
    return Outline(points, way.nodes, tuple(corners))


def closed_points(
    corners: Sequence[str], turns: Sequence[float], lengths: Sequence[float], start: Pose
) -> tuple[Point, ...]:
    """Places (m) of the corners of a closed boundary. lengths: of the edge that leaves each corner (m).

    start: the first corner, with the heading of the wall by which it is reached.
    """
    trace = BoundaryTrace()
    trace.corners = [Corner(kind, 0.0, turn) for kind, turn in zip(corners, turns, strict=True)]
    if trace.is_right_angled:
        turns = [_QUARTER * round(turn / _QUARTER) for turn in turns]
    lack = (math.copysign(math.tau, math.fsum(turns)) - math.fsum(turns)) / len(turns)
    x, y, heading = start.x, start.y, start.heading
    points = [(x, y)]
    for turn, length in zip(turns, lengths, strict=True):
        heading += turn + lack
        x, y = x + length * math.cos(heading), y + length * math.sin(heading)
        points.append((x, y))
    gap = x - start.x, y - start.y
    return close_polygon(points[:-1], lengths, gap, math.fsum(lengths) or 1.0)


def outlines(hybrid: HybridMap) -> list[Outline]:
    """The closed boundaries of a map that lie in its frame: that of node 0, then what crossings led to."""
    found = []
    seen: set[int] = set()
    for node in hybrid.nodes():
        if node in seen or (node and place_in(hybrid.graph.nodes[node]["notes"]) is None):
            continue
        outline = outline_from(hybrid, node)
        if outline is not None:
            found.append(outline)
            seen.update(outline.nodes)
    return found


@dataclass(frozen=True, slots=True)
class Mark:
    """A place on an outline: which one, the edge, how far along it (m)."""

    outline: int
    edge: int
    along: float


def first_hit(
    all_outlines: Sequence[Outline], x: float, y: float, heading: float
) -> tuple[float, Mark] | None:
    """How far (m) a straight way leads until it meets an outline, and where; not where it sets out."""
    best: tuple[float, Mark] | None = None
    cos_h, sin_h = math.cos(heading), math.sin(heading)
    for index, outline in enumerate(all_outlines):
        for edge in range(len(outline.points)):
            (x0, y0), (x1, y1) = outline.edge(edge)
            ex, ey = x1 - x0, y1 - y0
            cross = cos_h * ey - sin_h * ex
            if abs(cross) < 1e-12:
                continue
            way = ((x0 - x) * ey - (y0 - y) * ex) / cross
            share = ((x0 - x) * sin_h - (y0 - y) * cos_h) / cross
            if way > 1e-3 and 0.0 <= share <= 1.0 and (best is None or way < best[0]):
                best = (way, Mark(index, edge, share * math.hypot(ex, ey)))
    return best


def to_segment(point: Point, start: Point, end: Point) -> tuple[float, float]:
    """(distance, how far along from start) of a point to a segment (m)."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    if length < 1e-12:
        return math.dist(point, start), 0.0
    along = ((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / length
    along = max(0.0, min(length, along))
    nearest = (start[0] + along * dx / length, start[1] + along * dy / length)
    return math.dist(point, nearest), along


def signed_area(points: Sequence[Point]) -> float:
    """Area (m^2) of a polygon, positive when its points run counter-clockwise."""
    ring = pairwise([*points, points[0]])
    return 0.5 * math.fsum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in ring)
