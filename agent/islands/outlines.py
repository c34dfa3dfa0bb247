"""Where the mapped boundaries lie in the map frame, and the straight ways between them.

An outline is the path of the robot's center along one boundary: its corners are the nodes, edge k leads from
node k to the next. Wall following makes arcs' lengths and turns good enough to lay it out by dead reckoning;
what is missing when it comes round is spread over turns, then over lengths.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from ...maps.boundary.layout import PLACE
from ...maps.boundary.walk import close_polygon, onward, walk
from ...world.robot import Pose, wrap_angle
from ..boundary.trace import BoundaryTrace, Corner

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap

Point = tuple[float, float]
_QUARTER = 0.5 * math.pi


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


def outline_from(hybrid: HybridMap, first: int) -> Outline | None:
    """The outline of the boundary that `first` is on, from the side mapped with; None if it is not closed."""
    way = walk(onward(hybrid, hybrid.meta.side), first)
    if not way.closed:
        return None
    data = [hybrid.graph.nodes[node] for node in way.nodes]
    x, y = data[0]["notes"].get(PLACE, (0.0, 0.0))
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
    """The closed boundaries of a map that are placed in its frame: that of node 0, then what forays found."""
    found = []
    seen: set[int] = set()
    for node in hybrid.nodes():
        if node in seen or (node and PLACE not in hybrid.graph.nodes[node]["notes"]):
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


@dataclass(frozen=True, slots=True)
class Chord:
    """A straight way through open space from one wall to another. u, v0, v1: m, in the frame of the sweep.

    line: which of the sweep's lines it is on or beside.
    """

    line: int
    u: float
    v0: float
    v1: float
    start: Mark
    end: Mark

    @property
    def length(self) -> float:
        """m."""
        return abs(self.v1 - self.v0)

    @property
    def back(self) -> Chord:
        """The same way in the other direction."""
        return Chord(self.line, self.u, self.v1, self.v0, self.end, self.start)


@dataclass(frozen=True, slots=True)
class Sweep:
    """Parallel lines over the inside of a boundary. axis: heading (rad) across the lines; u runs along it."""

    axis: float
    lines: tuple[float, ...]

    @classmethod
    def over(cls, outline: Outline, spacing: float) -> Sweep:
        """Lines perpendicular to the longest edge, at most `spacing` (m) apart; none along the first wall."""
        longest = max(range(len(outline.points)), key=outline.length)
        axis = outline.direction(longest)
        along = [_rotated(point, -axis)[0] for point in outline.points]
        low, high = min(along), max(along)
        count = max(1, math.ceil((high - low) / spacing))
        step = (high - low) / count
        return cls(axis, tuple(low + k * step for k in range(1, count)))

    def chords(self, all_outlines: Sequence[Outline], line: int, aside: float = 0.0) -> list[Chord]:
        """The free pieces of a line, moved aside by so many meters, in order."""
        u = self.lines[line] + aside
        met: list[tuple[float, Mark]] = []
        rings = [[_rotated(point, -self.axis) for point in outline.points] for outline in all_outlines]
        for index, ring in enumerate(rings):
            for edge, ((u0, v0), (u1, v1)) in enumerate(pairwise([*ring, ring[0]])):
                if (u0 <= u) != (u1 <= u):
                    share = (u - u0) / (u1 - u0)
                    along = share * math.hypot(u1 - u0, v1 - v0)
                    met.append((v0 + share * (v1 - v0), Mark(index, edge, along)))
        met.sort(key=lambda entry: entry[0])
        found = []
        for (v0, start), (v1, end) in pairwise(met):
            middle = (u, 0.5 * (v0 + v1))
            outer, *islands = (_inside(middle, ring) for ring in rings)
            if outer and not any(islands):
                found.append(Chord(line, u, v0, v1, start, end))
        return found

    def along_walls(self, all_outlines: Sequence[Outline]) -> list[tuple[float, float, float]]:
        """(u, v0, v1) of the edges that run along the lines: driven already, beside the wall."""
        found = []
        for outline in all_outlines:
            turned = [_rotated(point, -self.axis) for point in outline.points]
            for (u0, v0), (u1, v1) in pairwise([*turned, turned[0]]):
                if abs(u1 - u0) < 0.02 < abs(v1 - v0):
                    found.append((0.5 * (u0 + u1), v0, v1))
        return found

    def heading(self, chord: Chord) -> float:
        """Heading (rad, map frame) of a chord."""
        return wrap_angle(self.axis + math.copysign(_QUARTER, chord.v1 - chord.v0))

    def place(self, u: float, v: float) -> Point:
        """x, y (m, map frame) of a point of the sweep."""
        return _rotated((u, v), self.axis)

    def coordinates(self, x: float, y: float) -> Point:
        """u, v (m) of a point of the map frame."""
        return _rotated((x, y), -self.axis)


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


def uncovered(v0: float, v1: float, driven: Iterable[tuple[float, float]]) -> float:
    """Length (m) of the longest piece of v0..v1 outside all the intervals driven."""
    low, high = min(v0, v1), max(v0, v1)
    longest, reached = 0.0, low
    for start, end in sorted((min(pair), max(pair)) for pair in driven):
        longest = max(longest, min(start, high) - reached)
        reached = max(reached, end)
        if reached >= high:
            break
    return max(longest, high - reached)


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


def _rotated(point: Point, angle: float) -> Point:
    cos_a, sin_a = math.cos(angle), math.sin(angle)
    return cos_a * point[0] - sin_a * point[1], sin_a * point[0] + cos_a * point[1]


def _inside(point: Point, ring: Sequence[Point]) -> bool:
    """Whether a point is in a polygon, by the parity of a ray along y."""
    x, y = point
    odd = False
    for (x0, y0), (x1, y1) in pairwise([*ring, ring[0]]):
        if (x0 <= x) != (x1 <= x) and y0 + (x - x0) / (x1 - x0) * (y1 - y0) > y:
            odd = not odd
    return odd
