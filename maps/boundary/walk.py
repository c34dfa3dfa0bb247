"""The boundaries of a map as sequences of corners, all read in one direction: that of the right-hand arcs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from ..hybrid_map import HybridMap


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


def boundaries(hybrid: HybridMap) -> list[Boundary]:
    """The boundaries of a map, longest first; a node without right-hand arcs is in none."""
    following = {
        node: arc.end for node in hybrid.nodes() if (arc := hybrid.next_arc(node, "right")) is not None
    }
    reached = set(following.values())
    starts = [node for node in sorted(following) if node not in reached] + sorted(following)
    seen: set[int] = set()
    found = []
    for start in starts:
        if start in seen:
            continue
        chain = [start]
        seen.add(start)
        while (after := following.get(chain[-1])) is not None and after not in seen:
            chain.append(after)
            seen.add(after)
        if len(chain) > 1 or following.get(start) == start:
            found.append(_boundary(hybrid, chain, following.get(chain[-1]) == start))
    return sorted(found, key=lambda boundary: (-len(boundary), boundary.nodes))


def _boundary(hybrid: HybridMap, chain: list[int], closed: bool) -> Boundary:
    sign = -1.0 if hybrid.meta.side == "left" else 1.0
    data = [hybrid.graph.nodes[node] for node in chain]
    lengths = [hybrid.arc(a, b, "right").distance for a, b in pairwise(chain)]
    lengths.append(hybrid.arc(chain[-1], chain[0], "right").distance if closed else 0.0)
    return Boundary(
        tuple(chain),
        tuple(entry["corner"] for entry in data),
        tuple(sign * entry["turn"] for entry in data),
        tuple(lengths),
        closed,
    )


def mean_angle(angles: list[float]) -> float:
    """The circular mean of angles, rad in (-pi, pi]; 0 of none."""
    return math.atan2(sum(map(math.sin, angles)), sum(map(math.cos, angles)))
