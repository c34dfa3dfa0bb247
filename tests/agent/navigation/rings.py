"""Maps that are one loop."""

from __future__ import annotations

import math

from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta

QUARTER = 0.5 * math.pi
SQUARE = [1.0, 1.0, 1.0, 1.0]


def ring(lengths: list[float], convex: int | None = None) -> HybridMap:
    """A right-side map of a loop with these arcs; node `convex` is a convex corner."""
    found = HybridMap(MapMeta(side="right"))
    for node in range(len(lengths)):
        bent = node == convex
        found.add_node(corner="convex" if bent else "concave", turn=-QUARTER if bent else QUARTER)
    for node, length in enumerate(lengths):
        found.add_arc(node, (node + 1) % len(lengths), "right", length)
    return found
