"""Walks along a boundary: from node to node by the arcs of one side. The one place that does."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..hybrid_map import HybridMap

Onward = Mapping[int, tuple[int, float]]
"""node -> the node that follows it along the wall, and how far (m) it is."""


@dataclass(frozen=True, slots=True)
class Walk:
    """nodes: those passed, in order. lengths: m, of the arc that leaves each. end: where the last arc leads.

    A walk that ends at a node without an arc onward has one length less, and no end.
    """

    nodes: tuple[int, ...]
    lengths: tuple[float, ...]
    end: int | None

    @property
    def closed(self) -> bool:
        """Whether it leads back to where it began."""
        return self.end == self.nodes[0]

    @property
    def length(self) -> float:
        """All of it, m, added in order."""
        return in_order(self.lengths)


@dataclass(frozen=True, slots=True)
class Boundary:
    """Nodes along one wall. closed: whether the last joins the first.

    nodes, corners, turns: one entry a node; turns are rad, counter-clockwise, in the right-hand direction.
    lengths: m from each node to the next; the last one leads back to the first and is 0 when not closed.
    """

    nodes: tuple[int, ...]
    corners: tuple[str, ...]
    turns: tuple[float, ...]
    lengths: tuple[float, ...]
    closed: bool

    def __len__(self) -> int:
        """How many nodes it has."""
        return len(self.nodes)

    def between(self, start: int, end: int) -> float:
        """Length (m) from the node at index start on to the one at end; indices go on past the first."""
        return in_order(self.lengths[index % len(self)] for index in range(start, end))


def onward(hybrid: HybridMap, side: str) -> dict[int, tuple[int, float]]:
    """What follows each node along the wall on that side; a node without such an arc is left out."""
    arcs = ((node, hybrid.next_arc(node, side)) for node in hybrid.graph)
    return {node: (arc.end, arc.distance) for node, arc in arcs if arc is not None}


def walk(follow: Onward, first: int, stop: Container[int] = ()) -> Walk:
    """From node `first` on until no arc leads on, or one leads to a node passed before or in `stop`."""
    nodes, lengths, passed = [first], [], {first}
    while nodes[-1] in follow:
        end, length = follow[nodes[-1]]
        lengths.append(length)
        if end in passed or end in stop:
            return Walk(tuple(nodes), tuple(lengths), end)
        nodes.append(end)
        passed.add(end)
    return Walk(tuple(nodes), tuple(lengths), None)


def walks(follow: Onward, nodes: Iterable[int]) -> list[Walk]:
    """Walks that pass each node once: from those that nothing leads to, then round what is closed."""
    ordered = sorted(nodes)
    reached = {end for end, _ in follow.values()}
    seen: set[int] = set()
    found = []
    for start in [node for node in ordered if node not in reached] + ordered:
        if start not in seen:
            found.append(walk(follow, start, seen))
            seen.update(found[-1].nodes)
    return found


def boundaries(hybrid: HybridMap) -> list[Boundary]:
    """The boundaries of a map in the right-hand direction, longest first; a node without arcs is in none."""
    follow = onward(hybrid, "right")
    found = [_boundary(hybrid, way) for way in walks(follow, follow) if len(way.nodes) > 1 or way.closed]
    return sorted(found, key=lambda boundary: (-len(boundary), boundary.nodes))


def _boundary(hybrid: HybridMap, way: Walk) -> Boundary:
    sign = -1.0 if hybrid.meta.side == "left" else 1.0
    data = [hybrid.graph.nodes[node] for node in way.nodes]
    inner = way.lengths[: len(way.nodes) - 1]
    return Boundary(
        way.nodes,
        tuple(entry["corner"] for entry in data),
        tuple(sign * entry["turn"] for entry in data),
        (*inner, way.lengths[-1] if way.closed else 0.0),
        way.closed,
    )


def close_polygon(
    points: Sequence[tuple[float, float]], lengths: Sequence[float], gap: tuple[float, float], total: float
) -> tuple[tuple[float, float], ...]:
    """Points (m) shifted so that their polygon closes: the gap at its end is spread over the lengths.

    lengths: m, of the edge that leaves each point; total: their sum. gap: its end less its beginning, m.
    """
    closed, driven = [], 0.0
    for (x, y), length in zip(points, lengths, strict=True):
        closed.append((x - gap[0] * driven / total, y - gap[1] * driven / total))
        driven += length
    return tuple(closed)


def in_order(lengths: Iterable[float]) -> float:
    """The sum of lengths added one after another, the same in every version of Python."""
    total = 0.0
    for length in lengths:
        total += length
    return total


def mean_angle(angles: list[float]) -> float:
    """The circular mean of angles, rad in (-pi, pi]; 0 of none."""
    return math.atan2(sum(map(math.sin, angles)), sum(map(math.cos, angles)))
