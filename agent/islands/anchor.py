"""Where the robot is in the map frame: which node a corner is, and path integration that goes on there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...world.robot import Pose, wrap_angle
from ..boundary.trace import BEND
from ..codec import reinstate, snapshot
from ..events import CornerReached

if TYPE_CHECKING:
    from ..estimation.odometry import PathIntegrator
    from .outlines import Outline

_SAME_WALL = 0.35
"""Radians between the directions of two walls up to which they may be the same."""
_KEPT = ("corner", "_travelled")


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


class Anchor:
    """Keeps path integration in the map frame: at a known node it goes on from where that lies.

    corner: the last one met. near, near_slope: as in `ScoutConfig`.
    """

    def __init__(self, odometry: PathIntegrator, side: str, near: float, near_slope: float) -> None:
        """side: of the walls that the map was made by."""
        self._odometry, self._side = odometry, side
        self._near, self._near_slope = near, near_slope
        self.corner: CornerReached | None = None
        self._travelled = 0.0

    def meet(self, corner: CornerReached) -> None:
        """Takes a corner that was met; bends do not count."""
        if corner.kind != BEND:
            self.corner = corner

    def at(self, corner: CornerReached) -> Pose:
        """The robot's pose at a corner, heading along the wall it has just followed (map frame)."""
        pose = self._odometry.pose
        return Pose(pose.x, pose.y, corner.heading)

    def node_at(self, known: Sequence[Outline], corner: CornerReached) -> int | None:
        """The node that the corner is at which the robot stands; None if that cannot be told."""
        since = self._odometry.travelled - self._travelled
        slack = 2.0 * self._near + self._near_slope * since
        return node_at(known, self.at(corner), corner.kind, slack)

    def fix(self, known: Sequence[Outline], node: int) -> None:
        """The robot stands at a node, turned from its entry heading by what it saw there."""
        corner, odometry = self.corner, self._odometry
        if corner is None:
            return
        pose = pose_at(known, node, corner.side != self._side)
        if pose is not None:
            skew = odometry.heading - corner.heading
            odometry.reset(Pose(pose.x, pose.y, wrap_angle(pose.heading + skew)))
            self.corner = replace(corner, heading=pose.heading)
            self._travelled = odometry.travelled

    def state(self) -> dict[str, Any]:
        """All that changes, as JSON."""
        return snapshot(self, _KEPT)

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        reinstate(self, _KEPT, state)
