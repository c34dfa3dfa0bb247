"""Frames of two maps of one world, and boundaries matched by where they lie in them.

The corners of a small obstacle often match in several ways (a square block: four). Where a foray found it,
the map knows its place; once the outer boundaries are matched so are the frames, and the place decides.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..boundary.layout import Point, layout, place_in

if TYPE_CHECKING:
    from ..boundary.walk import Boundary
    from ..hybrid_map import HybridMap

SAME_PLACE = 0.1
"""Meters by which the places of one corner in two maps may differ, at most: forays are driven by odometry."""


class Frames:
    """The rotation (rad) and shift (m) that take places in the other map's frame to the one's."""

    def __init__(self, one: HybridMap, other: HybridMap, matched: dict[int, int], rotation: float) -> None:
        """From matched nodes; rotation: heading in the other's frame minus heading in the one's."""
        self._here, self._there = layout(one), layout(other)
        cosine, sine = math.cos(rotation), math.sin(rotation)
        self._turn = np.array([[cosine, sine], [-sine, cosine]])
        if matched:
            here = np.array([self._here[node] for node in matched])
            there = np.array([self._there[node] for node in matched.values()])
            self._shift = (here - there @ self._turn.T).mean(axis=0)
        else:
            self._shift = np.zeros(2)

    def moved(self, place: Point) -> Point:
        """A place in the other's frame, in the one's."""
        x, y = self._turn @ np.array(place) + self._shift
        return float(x), float(y)

    def match(self, left: Boundary, right: Boundary) -> dict[int, int]:
        """Nodes of both boundaries that lie at the same place; few if the boundaries are not the same."""
        here = np.array([self._here[node] for node in left.nodes])
        there = np.array([self.moved(self._there[node]) for node in right.nodes])
        apart: NDArray[np.float64] = np.linalg.norm(here[:, None] - there, axis=2)
        found = {}
        for i, j in enumerate(apart.argmin(axis=1).tolist()):
            same = left.corners[i] == right.corners[j] and apart[i, j] <= SAME_PLACE
            if same and int(apart[:, j].argmin()) == i:
                found[left.nodes[i]] = right.nodes[j]
        return found


def has_place(hybrid: HybridMap, boundary: Boundary) -> bool:
    """Whether the map knows where a boundary lies in its frame."""
    return any(place_in(hybrid.graph.nodes[node]["notes"]) is not None for node in boundary.nodes)
