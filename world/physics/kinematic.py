"""The kinematic twin: exact differential drive, circular shells that slide along what they touch. No DART."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..robot import CONTROL_PERIOD, Pose, wrap_angle
from .simulated import SimulatedWorld

_PUSHES = 8
"""Corrections a tick at most: two walls that meet need a few."""


def drive(pose: Pose, left: float, right: float, radius: float, track: float, duration: float) -> Pose:
    """Where a differential drive is after turning its wheels at constant speeds (rad/s) for `duration` (s).

    Exact: an arc of a circle, or a straight line.
    """
    forward = radius * (left + right) / 2 * duration
    turn = radius * (right - left) / track * duration
    half = turn / 2
    chord = forward * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    return Pose(
        pose.x + chord * math.cos(pose.heading + half),
        pose.y + chord * math.sin(pose.heading + half),
        wrap_angle(pose.heading + turn),
    )


class KinematicWorld(SimulatedWorld):
    """Pure Python and numpy. Other robots and movable boxes are obstacles that stand fast.

    A shell that touches something is moved out of it the shortest way, so it slides without friction.
    """

    kind = "kinematic"

    def _advance(self, speeds: Sequence[tuple[float, float]]) -> None:
        track = self.geometry.track * (1.0 + self.noise.wrong_track)
        for index, (left, right) in enumerate(speeds):
            moved = drive(
                self.surroundings.robots[index],
                left,
                right,
                self.geometry.wheel_radius,
                track,
                CONTROL_PERIOD,
            )
            self.surroundings.robots[index] = self._pushed_out(moved, index)

    def _pushed_out(self, pose: Pose, index: int) -> Pose:
        radius = self.geometry.body_radius
        x, y = pose.x, pose.y
        for _ in range(_PUSHES):
            gaps = self.surroundings.plan.gaps(x, y, radius)
            if not self.surroundings.alone:
                gaps += self.surroundings.moving_gaps(index, x, y, radius)
            if not gaps:
                break
            distance, away_x, away_y = min(gaps)
            x, y = x + (radius - distance) * away_x, y + (radius - distance) * away_y
        return Pose(x, y, pose.heading)

    def _read(self, index: int) -> Pose:
        return self.surroundings.robots[index]

    def _put(self, index: int, pose: Pose) -> None:
        self.surroundings.robots[index] = pose

    def _bodies(self) -> Any:
        return None

    def _restore_bodies(self, bodies: Any) -> None:
        """All there is are the poses."""
