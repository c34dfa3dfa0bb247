"""Parallel lines over what a boundary encloses, and the pieces of them that lead through open space."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ...world.robot import wrap_angle
from .outlines import Mark, Outline, Point

_QUARTER = 0.5 * math.pi


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
