"""What navigation asks of local behaviors where walls keep the pose: plain data, as in `goals`."""

from __future__ import annotations

from dataclasses import dataclass

from ..world.robot import Pose


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
