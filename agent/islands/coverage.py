"""Which forays to make: lines over what a boundary encloses and nothing is known of; links to islands."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ...maps.errors import NoPathError
from ...world.robot import Pose, wrap_angle
from ..goals import Crossing
from ..walls import WALL_DISTANCE
from .outlines import Chord, Mark, Outline, Point, Sweep, first_hit, outlines, uncovered

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap


@dataclass(frozen=True, slots=True)
class ScoutConfig:
    """Settings of the search for islands. Lengths in m.

    spacing: between neighboring lines, at most. The shell and what the side sensors see sweep 9 cm of it, so
    every obstacle wider than `spacing` - 0.09 is met, less how far a foray drifts aside; smallest: what is
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


_ROOM = {"concave": (0.03, 0.02), "convex": (0.14, 0.085)}
"""Along an edge (m): the first place to set out from after a corner, and how far before one the last is."""
_SAME_WALL = 0.35
"""Radians between the directions of two walls up to which they may be the same."""
_SLANT = 0.5
"""Sine of the least angle between a wall and the way that leaves it."""


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

    def state(self) -> dict[str, Any]:
        """All that changes, as JSON."""
        return {
            "axis": self.sweep.axis,
            "lines": list(self.sweep.lines),
            "driven": [list(piece) for piece in self.driven],
            "tried": dict(self.tried),
            "blind": [[list(point) for point in outline.points] for outline in self.blind],
        }

    @classmethod
    def restored(cls, state: Mapping[str, Any], config: ScoutConfig) -> Scouting:
        """Back at a `state`."""
        return cls(
            Sweep(float(state["axis"]), tuple(state["lines"])),
            config,
            [(u, v0, v1) for u, v0, v1 in state["driven"]],
            {str(key): int(count) for key, count in state["tried"].items()},
            [Outline(tuple((x, y) for x, y in points)) for points in state["blind"]],
        )

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
        """A line as a foray, and the pose where it leaves the wall, heading along it."""
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
    low, high = _leave_range(outline, mark.edge)
    return low <= mark.along <= high and abs(math.sin(heading - outline.direction(mark.edge))) >= _SLANT


def _leave_range(outline: Outline, edge: int) -> tuple[float, float]:
    first, last = outline.corners[edge], outline.corners[(edge + 1) % len(outline.corners)]
    low = _ROOM.get(first, _ROOM["convex"])[0]
    return low, outline.length(edge) - _ROOM.get(last, _ROOM["convex"])[1]


def nodes_near(known: Sequence[Outline], corner: Pose, kind: str, slack: float) -> dict[int, float]:
    """The nodes that a corner of this kind may be, and how far (m) each is; none beyond `slack`.

    corner: where the robot stands, heading along the wall it has just followed (m, rad, map frame).
    """
    found = {}
    for outline in known:
        for index, node in enumerate(outline.nodes):
            away = math.dist(outline.points[index], (corner.x, corner.y))
            turned = abs(wrap_angle(outline.direction(index - 1) - corner.heading))
            if outline.corners[index] == kind and turned < _SAME_WALL and away <= slack:
                found[node] = away
    return found


def node_at(known: Sequence[Outline], corner: Pose, kind: str, slack: float) -> int | None:
    """The node that a corner is; None if none is, or several may be. Arguments: as for `nodes_near`."""
    fits = sorted((away, node) for node, away in nodes_near(known, corner, kind, slack).items())
    if not fits or (len(fits) > 1 and fits[1][0] < fits[0][0] + 0.4 * slack):
        return None
    return fits[0][1]


def pose_at(known: Sequence[Outline], node: int, backward: bool) -> Pose | None:
    """Where `node` is, heading along the wall by which it is reached; backward: by the other side."""
    for outline in known:
        if node in outline.nodes:
            index = outline.nodes.index(node)
            x, y = outline.points[index]
            heading = outline.direction(index) + math.pi if backward else outline.direction(index - 1)
            return Pose(x, y, wrap_angle(heading))
    return None


@dataclass(frozen=True, slots=True)
class Link:
    """A foray from one boundary to another, as it should go. risk: m, lower is better."""

    start: int
    end: int
    crossing: Crossing
    risk: float


def best_link(
    known: Sequence[Outline],
    sources: Sequence[int],
    targets: Sequence[int],
    side: str,
    failed: Collection[tuple[int, int]] = (),
) -> Link | None:
    """The foray from one of the outlines `sources` to one of `targets` that is surest to arrive.

    failed: pairs of nodes that are not to be joined.
    """
    free = 0.5 * math.pi if side == "right" else -0.5 * math.pi
    best: Link | None = None
    for target in targets:
        outline = known[target]
        for edge in range(len(outline.points)):
            (x0, y0), (x1, y1) = outline.edge(edge)
            middle = (0.5 * (x0 + x1), 0.5 * (y0 + y1))
            across = outline.direction(edge) + free + math.pi
            for source in sources:
                if source == target or not known[source].nodes:
                    continue
                for link in _links(known, source, target, middle, across, free):
                    if (link.start, link.end) in failed:
                        continue
                    if best is None or link.risk < best.risk - 1e-9:
                        best = link
    return best


def _links(
    known: Sequence[Outline],
    source: int,
    target: int,
    middle: tuple[float, float],
    across: float,
    free: float,
) -> list[Link]:
    """Forays from an outline toward a point of another: off its walls, and straight from convex corners."""
    outline = known[source]
    found = []
    for edge in range(len(outline.points)):
        low, high = _leave_range(outline, edge)
        (x, y), along = outline.edge(edge)[0], outline.direction(edge)
        for heading in (along + free, across):
            if math.sin(heading - along) * math.copysign(1.0, free) < _SLANT or high < low:
                continue
            # Where a straight way to the point leaves the edge.
            dx, dy = middle[0] - x, middle[1] - y
            beside = dx * math.cos(along) + dy * math.sin(along)
            beyond = -dx * math.sin(along) + dy * math.cos(along)
            offset = beside - beyond / math.tan(heading - along)
            offset = max(low, min(high, offset))
            place = (x + offset * math.cos(along), y + offset * math.sin(along))
            found.append(_link(known, source, target, edge, offset, place, heading, along))
        entry = outline.direction(edge - 1)
        if outline.corners[edge] == "convex":
            heading = math.atan2(middle[1] - y, middle[0] - x)
            aside = wrap_angle(heading - entry) * math.copysign(1.0, free)
            if -0.8 < aside < 1.0:
                found.append(_link(known, source, target, edge, 0.0, (x, y), heading, entry))
    return [link for link in found if link is not None]


def _link(
    known: Sequence[Outline],
    source: int,
    target: int,
    edge: int,
    offset: float,
    place: Point,
    heading: float,
    along: float,
) -> Link | None:
    hit = first_hit(known, *place, heading)
    if hit is None or hit[1].outline != target or not known[target].nodes:
        return None
    distance, mark = hit
    met = known[target]
    length, wall = met.length(mark.edge), wrap_angle(met.direction(mark.edge) - heading)
    margin = min(mark.along, length - mark.along) - WALL_DISTANCE
    lack = max(0.0, 0.03 + 0.05 * distance - margin)
    slant = 1.0 - abs(math.sin(wall))
    end = met.nodes[(mark.edge + 1) % len(met.nodes)]
    crossing = Crossing(offset, wrap_angle(heading - along), distance, wall, length - mark.along)
    risk = distance + 20.0 * lack + 0.3 * slant + (0.1 if offset == 0.0 else 0.0)
    return Link(known[source].nodes[edge], end, crossing, risk)
