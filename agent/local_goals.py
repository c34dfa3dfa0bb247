"""What navigation asks of local behaviors where walls keep the pose: plain data, as in `goals`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..world.robot import Pose

_BEYOND = 0.03
"""Meters past a wall's end from where its foot can be seen, sensors turned to and fro."""


@dataclass(frozen=True, slots=True)
class LocalBelief:
    """What `agent.estimation.local_filter.LocalPose` holds, so that one behavior can go on for another.

    pose: x, y (m), heading (rad), local frame, drift_rate (rad/m). covariance: xx, xy, xt, yy, yt, tt;
    drift_rate: its covariances with x, y and heading, and its variance. walls: each as normal
    (rad), offset (m), their variances, and a vantage point's x, y (m). square: all walls stand square.
    """

    pose: tuple[float, float, float, float]
    covariance: tuple[float, float, float, float, float, float]
    drift_rate: tuple[float, float, float, float]
    walls: tuple[tuple[float, float, float, float, float, float], ...] = ()
    square: bool = False


@dataclass(frozen=True, slots=True)
class DrivePathWithLandmarks:
    """Drive through these places (m, local frame of the belief), then face `heading` (rad) if it is given.

    fix: whether to look for the walls at the end, turning to and fro.
    """

    places: tuple[tuple[float, float], ...]
    belief: LocalBelief
    heading: float | None = None
    fix: bool = False


@dataclass(frozen=True, slots=True)
class PlacesByWalls:
    """How `DrivePathWithLandmarks` went. reached: how many of the places; pose: where it ended; belief:
    all it holds."""

    reached: int
    pose: Pose
    belief: LocalBelief


def walls_at(
    side: str, kind: str, *, square: bool, distance: float
) -> tuple[tuple[float, float, float], ...]:
    """The walls known at a corner: the one followed to it and, if all walls are square, the other one.

    Each as `goals.ExploreLocally` has them: direction to it (rad, local frame), distance (m), standard
    deviation of the direction (rad). side: of the wall followed. kind: of the corner. distance: at which
    walls are followed (m).
    """
    beside = -0.5 * math.pi if side == "right" else 0.5 * math.pi
    ahead = math.pi if kind == "convex" else 0.0
    known = ((beside, distance, 0.005), (ahead, distance, 0.008))
    return known if square else known[:1]


def vantage_of(kind: str, walls: tuple[tuple[float, float, float], ...], index: int) -> tuple[float, float]:
    """From where (x, y in m, local frame) a wall known at a corner of that kind can be seen, foot and all.

    The node itself; but at a convex corner the wall followed to it ends behind the node, and the other one
    begins beside it.
    """
    if kind != "convex":
        return (0.0, 0.0)
    normal, distance, _ = walls[0]
    if index == 0:
        return (-distance - _BEYOND, 0.0)
    return (0.0, math.copysign(distance + _BEYOND, normal))
