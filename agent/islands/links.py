"""What a map knows of islands: the ways across open space to them, and which outlines are one obstacle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from ...maps.errors import NoPathError
from ..goals import Crossing
from ..mapping.base import ArcKey
from ..navigation.legs import CROSSING
from .coverage import best_link
from .outlines import Outline

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap

_SAME_PLACE = 0.12
"""Meters between the middles of two outlines of one obstacle, at most."""
_LINKS = 3
"""Ways tried to link an island, in each direction."""


def leads(hybrid_map: HybridMap, start: int, end: int) -> bool:
    """Whether the arcs that are not blocked lead from one node to another."""
    try:
        hybrid_map.path(start, end)
    except NoPathError:
        return False
    return True


def unproven_link(hybrid_map: HybridMap, node: int) -> Arc | None:
    """A foray arc that was never driven, and can be reached from the node."""
    for arc in hybrid_map.arcs():
        fresh = arc.kind == "foray" and arc.traversals == 0 and not arc.blocked
        if fresh and leads(hybrid_map, node, arc.start):
            return arc
    return None


def link_islands(hybrid_map: HybridMap, known: Sequence[Outline], side: str) -> None:
    """Sees to it that a foray leads to each island and one away, other than those that failed.

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


def arcs_into(hybrid_map: HybridMap, node: int, kind: str) -> list[Arc]:
    """The arcs of a kind that end at a node."""
    edges = hybrid_map.graph.in_edges(node, keys=True)
    return [hybrid_map.arc(*key) for key in sorted(edges) if key[2] == kind]


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
