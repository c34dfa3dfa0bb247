"""The infrared response the other way round: which raw value a distance is expected to give."""

from __future__ import annotations

from itertools import pairwise

from ...world.robot import RobotGeometry


def raw_value(geometry: RobotGeometry, distance: float) -> float:
    """The raw value expected at a distance (m) from the rim; 0 beyond the range.

    The inverse of `RobotGeometry.infrared_distance`, linear between the rows of the published response.
    """
    for (near, high, _), (far, low, _) in pairwise(geometry.infrared_response):
        if distance <= far:
            return high + (low - high) * (max(distance, near) - near) / (far - near)
    return 0.0
