"""Which crossings to make: lines over what a boundary encloses and nothing is known of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ...maps.errors import NoPathError
from ...world.robot import Pose, wrap_angle
from ..goals import Crossing
from .outlines import SLANT, Mark, Outline, outlines
from .sweep import Chord, Sweep, uncovered

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap


@dataclass(frozen=True, slots=True)
class ScoutConfig:
    """Settings of the search for islands. Lengths in m.

    spacing: between neighboring lines, at most. The shell and what the side sensors see sweep 9 cm of it, so
    every obstacle wider than `spacing` - 0.09 is met, less how far a crossing drifts aside; smallest: what is
    left of a line is driven only if it is longer. aside: a line may be moved by that share of `spacing` where
    it would set out too near to a corner. tries: of one line. near, near_slope: what is hit within near +
    near_slope x the distance driven of a known wall is taken for it.
    """

    spacing: float = 0.16
    smallest: float = 0.12
    aside: float = 0.25
    tries: int = 2
    near: float = 0.045
    near_slope: float = 0.035


@dataclass(slots=True)
class Scouting:
    """What has been driven, and what is to be driven next.

    driven: pieces of lines, (u, v0, v1) m in the sweep's frame. tried: how often, by line and direction.
    blind: outlines of obstacles that were met but could not be mapped.
    """

    sweep: Sweep
    config: ScoutConfig = field(default_factory=ScoutConfig)
    driven: list[tuple[float, float, float]] = field(default_factory=list)
    tried: dict[str, int] = field(default_factory=dict)
    blind: list[Outline] = field(default_factory=list)

    @classmethod
    def over(cls, hybrid: HybridMap, config: ScoutConfig) -> Scouting:
        """Nothing driven yet. The first boundary of the map must be closed."""
        return cls(Sweep.over(outlines(hybrid)[0], config.spacing), config)

    def all(self, hybrid: HybridMap) -> list[Outline]:
        """Every outline known."""
        return [*outlines(hybrid), *self.blind]

    def next(self, hybrid: HybridMap, node: int) -> Chord | None:
        """The line to drive next for a robot at `node`, the nearest; None if all is covered or tried."""
        known = self.all(hybrid)
        beside = [*self.driven, *self.sweep.along_walls(known)]
        best: tuple[float, Chord] | None = None
        ways: dict[int, float] = {}
        for line in range(len(self.sweep.lines)):
            for shift in (0.0, self.config.aside, -self.config.aside):
                for chord in self._open(known, line, shift * self.config.spacing, beside):
                    start = known[chord.start.outline].nodes[chord.start.edge]
                    if start not in ways:
                        ways[start] = _way(hybrid, node, start)
                    cost = ways[start] + chord.start.along + 0.1 * abs(shift)
                    if cost < math.inf and (best is None or cost < best[0] - 1e-9):
                        best = (cost, chord)
        return None if best is None else best[1]

    def _open(
        self,
        known: Sequence[Outline],
        line: int,
        aside: float,
        beside: Sequence[tuple[float, float, float]],
    ) -> list[Chord]:
        """The pieces of a line, in both directions, that are worth driving and can be set out on."""
        u = self.sweep.lines[line] + aside
        half = 0.5 * self.config.spacing + 1e-6
        driven = [(v0, v1) for at, v0, v1 in beside if abs(at - u) <= half]
        found = []
        for chord in self.sweep.chords(known, line, aside):
            if uncovered(chord.v0, chord.v1, driven) <= self.config.smallest:
                continue
            for way in (chord, chord.back):
                outline = known[way.start.outline]
                if self.tried.get(_key(way), 0) < self.config.tries and _can_leave(
                    outline, way.start, self.sweep.heading(way)
                ):
                    found.append(way)
        return found

    def try_once(self, chord: Chord) -> None:
        """Counts an attempt at a line."""
        self.tried[_key(chord)] = self.tried.get(_key(chord), 0) + 1

    def drove(self, chord: Chord, x: float, y: float) -> None:
        """Takes a line as driven from its start to a point (m, map frame)."""
        self.driven.append((chord.u, chord.v0, self.sweep.coordinates(x, y)[1]))

    def crossing(self, known: Sequence[Outline], chord: Chord) -> tuple[Crossing, Pose]:
        """A line as a crossing, and the pose where it leaves the wall, heading along it."""
        outline, mark = known[chord.start.outline], chord.start
        along = outline.direction(mark.edge)
        x, y = self.sweep.place(chord.u, chord.v0)
        turn = wrap_angle(self.sweep.heading(chord) - along)
        return Crossing(mark.along, turn, chord.length, 0.0, 0.0), Pose(x, y, along)

    def is_known(self, known: Sequence[Outline], x: float, y: float, driven: float) -> bool:
        """Whether what was hit at x, y (m, map frame), after so many meters, is a wall that is known."""
        slack = self.config.near + self.config.near_slope * driven
        return min(outline.distance(x, y) for outline in known) <= slack


def _key(chord: Chord) -> str:
    return f"{chord.line} {chord.start.outline} {chord.start.edge} {int(chord.v1 > chord.v0)}"


def _way(hybrid: HybridMap, node: int, start: int) -> float:
    try:
        return math.fsum(arc.distance for arc in hybrid.path(node, start))
    except NoPathError:
        return math.inf


def _can_leave(outline: Outline, mark: Mark, heading: float) -> bool:
    if not outline.nodes:
        return False
    low, high = outline.leave_range(mark.edge)
    return low <= mark.along <= high and abs(math.sin(heading - outline.direction(mark.edge))) >= SLANT
