"""What a look around at a corner says of the nodes of a map, by the panoramas taken when it was made."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...maps.errors import MapError
from ..exploration.panoramas import Panorama
from ..perception.compass import difference, sensitivity

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap

_NOISE, _TURN = 0.015, math.radians(1.0)
"""A panorama taken at the same corner again is unlike the first by this luminance, and as if turned by this.

Measured at corners of rooms with white and with patterned walls: 0.9 of both together on average and 1.3 at
most at the same corner or one that looks like it, at others 2.6 and more, 7.7 in the median."""
_APART = 1.5
"""Two nodes look different if their panoramas differ by more such deviations, both taken together."""
_STRANGE = 3.0
"""A panorama that fits no node better (deviations) is of something that is not on the map."""
_DEAD = 1.0
"""Nats by which no node is told from another: the panoramas of the map are single ones, with errors too."""


class NodeViews:
    """Compares panoramas, views in a node's entry heading, with those of the nodes. Loads maps on demand."""

    def __init__(self, hybrid_map: HybridMap, field: float) -> None:
        """field: the camera's horizontal field of view (rad)."""
        self._map = hybrid_map
        self._field = field
        self._known: dict[int, tuple[Panorama, float] | None] = {}

    def any_apart(self, pairs: Iterable[tuple[int, int]]) -> bool:
        """Whether a look around could tell the nodes of any of the pairs apart."""
        return any(self._apart(one, other) for one, other in pairs)

    def against(self, panorama: Panorama, nodes: Iterable[int]) -> dict[int, float]:
        """What a panorama (4, height, width) says of each node (nats, 0 or less), against the best of them.

        0 for nodes without a panorama; empty if it fits none, and so says nothing.
        """
        fits: dict[int, float] = {}
        others: list[int] = []
        for node in nodes:
            known = self._reference(node)
            if known is None or known[0].shape != panorama.shape:
                others.append(node)
            else:
                fits[node] = difference(known[0], panorama, self._field) / known[1]
        best = min(fits.values(), default=math.inf)
        if best > _STRANGE:
            return {}
        says = {node: -max(0.0, 0.5 * (fit**2 - best**2) - _DEAD) for node, fit in fits.items()}
        return says | dict.fromkeys(others, 0.0)

    def _apart(self, one: int, other: int) -> bool:
        known, second = self._reference(one), self._reference(other)
        if known is None or second is None or known[0].shape != second[0].shape:
            return False
        return difference(known[0], second[0], self._field) > _APART * math.hypot(known[1], second[1])

    def _reference(self, node: int) -> tuple[Panorama, float] | None:
        """A node's panorama and the deviation of another taken there, None if it has none."""
        if node not in self._known:
            self._known[node] = self._load(node)
        return self._known[node]

    def _load(self, node: int) -> tuple[Panorama, float] | None:
        local_map = self._map.graph.nodes[node]["local_map"]
        try:
            panorama = None if local_map is None else local_map.entry_panorama
        except MapError:
            # A damaged local map: the boundary alone must do, as for nodes without one.
            return None
        if panorama is None:
            return None
        return panorama, math.hypot(_NOISE, sensitivity(panorama, self._field, _TURN))
