"""Elementary motion: wheel commands for turning in place and for driving along a heading."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..world.robot import CONTROL_PERIOD, Percept, RobotGeometry, WheelCommand

_SHY, _SHY_RATE = 0.004, 1.0
"""Meters from the shell within which a drive turns away, and how fast (rad/s) where it touches."""
_CLOSER = 0.0015
"""Meters that a drive must come nearer to a point for it to be in the way."""


def spin_command(geometry: RobotGeometry, remaining: float, limit: float) -> WheelCommand:
    """A turn in place by `remaining` (rad, counter-clockwise) or what `limit` (steps/s) allows in a tick."""
    speed = remaining / (2.0 * geometry.radians_per_step * CONTROL_PERIOD)
    speed = max(-limit, min(limit, speed))
    return WheelCommand(-speed, speed)


def drive_command(geometry: RobotGeometry, speed: float, turn_rate: float) -> WheelCommand:
    """`speed` (steps/s, negative is backwards) while turning at `turn_rate` (rad/s, counter-clockwise)."""
    limit = 0.8 * abs(speed)
    difference = 0.5 * turn_rate / geometry.radians_per_step
    difference = max(-limit, min(limit, difference))
    return WheelCommand(speed - difference, speed + difference)


def shy_turn(points: Iterable[tuple[float, float]], geometry: RobotGeometry) -> float:
    """Turn rate (rad/s, counter-clockwise) away from what the shell nearly touches beside or ahead of it.

    A drive at a slant to a wall comes near it too slowly for `is_free` to tell, and would end by grazing it.
    """
    away = 0.0
    for x, y in points:
        gap = math.hypot(x, y) - geometry.body_radius
        if gap < _SHY and x > -0.5 * geometry.body_radius:
            away -= math.copysign(_SHY_RATE * (1.0 - gap / _SHY), y)
    return max(-_SHY_RATE, min(_SHY_RATE, away))


def obstacles(percept: Percept, geometry: RobotGeometry) -> list[tuple[float, float]]:
    """Points (m, robot frame) that the infrared sensors hit, those out of range left out."""
    points = []
    far = geometry.infrared_response[-1][1]
    for value, angle in zip(percept.infrared, geometry.infrared_angles, strict=True):
        if value > far:
            reach = geometry.body_radius + geometry.infrared_distance(value)
            points.append((reach * math.cos(angle), reach * math.sin(angle)))
    return points


def is_free(
    points: Iterable[tuple[float, float]], geometry: RobotGeometry, way: float, margin: float
) -> bool:
    """Whether the shell keeps `margin` (m) from all points while driving `way` (m; negative: backwards).

    Points that the drive hardly comes nearer to do not count: whoever stands close to a wall may go away.
    """
    clearance = (geometry.body_radius + margin) ** 2
    direction = 1.0 if way >= 0.0 else -1.0
    length = abs(way)
    for x, y in points:
        along = x * direction
        if along <= 0.0:
            continue
        beyond = max(0.0, along - length)
        nearest = beyond * beyond + y * y
        if nearest < clearance and math.sqrt(x * x + y * y) - math.sqrt(nearest) > _CLOSER:
            return False
    return True
