"""An obstacle that may be an island, while it is followed: where it is, how it turns, what it may be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .anchor import nodes_near
from .outlines import Outline, Point

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap
    from ...world.robot import Pose
    from ..events import CornerReached

ROUND = 2.4 * math.pi
"""Turned so far (rad) along an obstacle without a corner: it is round."""
_TRACK_STEP = 0.04
_ASTRAY = 0.25
"""Meters that path integration may be off on a crossing, at most."""


@dataclass(slots=True)
class Candidate:
    """first: its first node. place: its first corner, heading along the wall there (map frame).

    track: places (m) along it. turned: rad, along it so far. maybe: nodes that the last corner may have been.
    """

    first: int | None = None
    place: Pose | None = None
    track: list[Point] = field(default_factory=list)
    turned: float = 0.0
    maybe: list[int] = field(default_factory=list)

    def follow(self, pose: Pose, turn: float) -> None:
        """Takes a tick along its wall. turn: rad."""
        self.turned += turn
        if not self.track or math.dist(self.track[-1], (pose.x, pose.y)) > _TRACK_STEP:
            self.track.append((pose.x, pose.y))

    @property
    def outline(self) -> Outline:
        """Where it was followed, if it cannot be mapped."""
        return Outline(tuple(self.track))

    def known_as(
        self, hybrid_map: HybridMap, known: Sequence[Outline], corner: Pose, event: CornerReached
    ) -> int | None:
        """The node that the corner is, if that and the one before are known ones, one after the other.

        corner: where the robot is, heading along the wall it has followed. To be asked once for each corner.
        """
        now = sorted(nodes_near(known, corner, event.kind, _ASTRAY))
        before, self.maybe = self.maybe, now
        for node in now:
            for arc in _arcs_into(hybrid_map, node, hybrid_map.meta.side):
                slack = 0.02 + 0.02 * arc.distance
                if arc.start in before and abs(arc.distance - event.path_length) < slack:
                    return node
        return None


def _arcs_into(hybrid_map: HybridMap, node: int, kind: str) -> list[Arc]:
    """The arcs of a kind that end at a node."""
    edges = hybrid_map.graph.in_edges(node, keys=True)
    return [hybrid_map.arc(*key) for key in sorted(edges) if key[2] == kind]
