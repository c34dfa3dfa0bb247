"""Start poses for worlds that name none: beside a straight wall, inside, facing along it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .errors import WorldFileError
from .geometry import Floats, Plan, Point, cast
from .robot import EPUCK, Pose, wrap_angle

if TYPE_CHECKING:
    from .spec import WorldSpec

BESIDE = 0.057
"""Distance (m) of the robot's center from the wall."""
AHEAD = 0.08
"""Free way (m) before and behind the robot's center, at least."""
_RAYS = 36
_TRIES = 400


def with_starts(
    spec: WorldSpec, near: Point | None = None, is_free: Callable[[Point], bool] | None = None
) -> WorldSpec:
    """The world with starts `right` and `left` (wall on that side) added behind those it has.

    near: a point (m) to be as close to as possible; else the longest wall is taken. is_free: whether a place
    (m) lies where robots may be, if walls alone do not tell. A world too small for a robot, or open on all
    sides, keeps the starts it has.
    """
    place = find_start(Plan(spec.shapes), near, is_free)
    if place is None:
        return spec
    back = replace(place, heading=wrap_angle(place.heading + math.pi))
    return spec.with_starts(right=place, left=back)


def find_start(
    plan: Plan, near: Point | None = None, is_free: Callable[[Point], bool] | None = None
) -> Pose | None:
    """A pose with a wall to the right at BESIDE meters, room ahead, and walls all around; or None."""
    segments = plan.segments
    along = segments[:, 2:] - segments[:, :2]
    lengths = np.hypot(along[:, 0], along[:, 1])
    middles = (segments[:, :2] + segments[:, 2:]) / 2
    order = -lengths if near is None else np.hypot(*(middles - near).T)
    for index in np.argsort(order, kind="stable")[:_TRIES].tolist():
        if lengths[index] < 2 * AHEAD:
            continue
        direction = along[index] / lengths[index]
        outward = np.array((direction[1], -direction[0]))
        for share in (0.5, 0.25, 0.75):
            x, y = segments[index, :2] + share * along[index] + BESIDE * outward
            pose = Pose(float(x), float(y), math.atan2(-direction[1], -direction[0]))
            if (is_free is None or is_free((pose.x, pose.y))) and _good(plan, pose):
                return pose
    return None


def _good(plan: Plan, pose: Pose) -> bool:
    radius = EPUCK.body_radius
    for ahead in (0.0, AHEAD, -AHEAD):
        point = pose.compose(ahead, 0.0)
        if plan.clearance(point.x, point.y) < (BESIDE - 1e-4 if ahead == 0.0 else radius + 0.005):
            return False
    return is_walled_in(plan, pose.x, pose.y)


def is_walled_in(plan: Plan, x: float, y: float) -> bool:
    """Whether there are walls all around a place (m)."""
    turns = np.arange(_RAYS) * math.tau / _RAYS + 0.01
    directions: Floats = np.stack((np.cos(turns), np.sin(turns)), 1)
    origins = np.broadcast_to(np.array((x, y)), directions.shape)
    return bool(np.isfinite(cast(origins, directions, plan.segments)).all())


def require_start(spec: WorldSpec, source: str) -> WorldSpec:
    """The world itself.

    Raises: WorldFileError when it has no start.
    """
    if not spec.starts:
        raise WorldFileError(f"{source}: no place beside a wall where a robot fits; is the scale right?")
    return spec
