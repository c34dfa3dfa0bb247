"""What a map knows of islands: the ways across open space to them, and which outlines are one obstacle."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, NamedTuple

from ...maps.errors import NoPathError
from ...world.robot import wrap_angle
from ..goals import Crossing
from ..mapping.base import ArcKey
from ..navigation.legs import CROSSING
from ..walls import WALL_DISTANCE, away_from
from .outlines import SLANT, Outline, Point, first_hit

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap

_SAME_PLACE = 0.12
"""Meters between the middles of two outlines of one obstacle, at most."""
_LINKS = 3
"""Ways tried to link an island, in each direction."""


@dataclass(frozen=True, slots=True)
class Link:
    """A crossing from one boundary to another, as it should go. risk: m, lower is better."""

    start: int
    end: int
    crossing: Crossing
    risk: float


def leads(hybrid_map: HybridMap, start: int, end: int) -> bool:
    """Whether the arcs that are not blocked lead from one node to another."""
    try:
        hybrid_map.path(start, end)
    except NoPathError:
        return False
    return True


def unproven_link(hybrid_map: HybridMap, node: int) -> Arc | None:
    """An arc across open space that was never driven, and can be reached from the node."""
    for arc in hybrid_map.arcs():
        fresh = arc.kind == "foray" and arc.traversals == 0 and not arc.blocked
        if fresh and leads(hybrid_map, node, arc.start):
            return arc
    return None


def link_islands(hybrid_map: HybridMap, known: Sequence[Outline], side: str) -> None:
    """Adds crossings so that one leads to each island and one away, other than those that failed.

    known: the outer boundary first, then the islands. side: on which walls are followed.
    """
    for index, island in enumerate(known[1:], 1):
        if not island.nodes:
            continue
        others = [other for other in range(len(known)) if other != index]
        for sources, targets, nodes in ((others, [index], 1), ([index], others, 0)):
            arcs = [
                arc
                for arc in hybrid_map.arcs()
                if arc.kind == "foray" and (arc.start, arc.end)[nodes] in island.nodes
            ]
            if len(arcs) < _LINKS and all(arc.blocked for arc in arcs):
                link = best_link(known, sources, targets, side, {(a.start, a.end) for a in arcs})
                if link is not None:
                    _add_link(hybrid_map, link.start, link.end, link.crossing, side)


def _add_link(hybrid_map: HybridMap, start: int, end: int, crossing: Crossing, side: str) -> None:
    distance = crossing.offset + crossing.distance + crossing.join
    hybrid_map.add_arc(
        start,
        end,
        side,
        distance,
        (0.02 + 0.03 * crossing.distance) ** 2,
        both_ways=False,
        kind="foray",
        traversals=0,
        notes={CROSSING: asdict(crossing)},
    )


def best_link(
    known: Sequence[Outline],
    sources: Sequence[int],
    targets: Sequence[int],
    side: str,
    failed: Collection[tuple[int, int]] = (),
) -> Link | None:
    """The crossing from one of the outlines `sources` to one of `targets` that is surest to arrive.

    failed: pairs of nodes that are not to be joined.
    """
    free = 0.5 * math.pi * away_from(side)
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
                for leaving in _leavings(known[source], middle, across, free):
                    link = _link(known, known[source], leaving, target)
                    if link is None or (link.start, link.end) in failed:
                        continue
                    if best is None or link.risk < best.risk - 1e-9:
                        best = link
    return best


class _Leaving(NamedTuple):
    """Where a way leaves an outline: `offset` m along an edge, at `place` (m), by a `heading` (rad).

    along: direction (rad) from which it turns there.
    """

    edge: int
    offset: float
    place: Point
    heading: float
    along: float


def _leavings(outline: Outline, middle: Point, across: float, free: float) -> Iterator[_Leaving]:
    """Ways from an outline toward a point of another: off its walls, straight from convex corners."""
    for edge in range(len(outline.points)):
        low, high = outline.leave_range(edge)
        (x, y), along = outline.edge(edge)[0], outline.direction(edge)
        for heading in (along + free, across):
            if math.sin(heading - along) * math.copysign(1.0, free) < SLANT or high < low:
                continue
            # Where a straight way to the point leaves the edge.
            dx, dy = middle[0] - x, middle[1] - y
            beside = dx * math.cos(along) + dy * math.sin(along)
            beyond = -dx * math.sin(along) + dy * math.cos(along)
            offset = beside - beyond / math.tan(heading - along)
            offset = max(low, min(high, offset))
            place = (x + offset * math.cos(along), y + offset * math.sin(along))
            yield _Leaving(edge, offset, place, heading, along)
        entry = outline.direction(edge - 1)
        if outline.corners[edge] == "convex":
            heading = math.atan2(middle[1] - y, middle[0] - x)
            aside = wrap_angle(heading - entry) * math.copysign(1.0, free)
            if -0.8 < aside < 1.0:
                yield _Leaving(edge, 0.0, (x, y), heading, entry)


def _link(known: Sequence[Outline], source: Outline, leaving: _Leaving, target: int) -> Link | None:
    edge, offset, place, heading, along = leaving
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
    return Link(source.nodes[edge], end, crossing, risk)


def take_back(hybrid_map: HybridMap, nodes: Iterable[int]) -> tuple[list[int], list[ArcKey]]:
    """Removes nodes: those, and the arcs that went with them."""
    gone: list[int] = []
    arcs: list[ArcKey] = []
    for node in list(nodes):
        gone.append(node)
        graph = hybrid_map.graph
        arcs += [*graph.in_edges(node, keys=True), *graph.out_edges(node, keys=True)]
        hybrid_map.remove_node(node)
    return gone, arcs


def is_same(one: Outline, other: Outline) -> bool:
    """Whether two outlines are of one obstacle, as obstacles cannot overlap."""
    return math.dist(one.middle, other.middle) < _SAME_PLACE
