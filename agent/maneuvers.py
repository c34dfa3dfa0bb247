"""Goals of the smaller behaviors: plain data, so that a mission can ask without importing a behavior."""

from __future__ import annotations

from dataclasses import dataclass

from ..world.robot import Pose


@dataclass(frozen=True, slots=True)
class AlignToWall:
    """Turn in place until the wall on `side` ("right" or "left") is parallel."""

    side: str = "right"


@dataclass(frozen=True, slots=True)
class Foray:
    """Drive straight across open space until a wall is near, at most `max_distance` (m).

    turn: rad, counter-clockwise, to turn in place before.
    """

    turn: float = 0.0
    max_distance: float = 3.0


@dataclass(frozen=True, slots=True)
class Dock:
    """Come to rest at `pose` (m, rad, path-integrated frame), trimmed by the walls that are known there.

    side: where a wall is parallel to the final heading, "right", "left" or None. wall_ahead: distance (m)
    of the center from the wall ahead in the docked pose, None where there is none.
    """

    pose: Pose
    side: str | None = None
    wall_ahead: float | None = None
