"""What the page draws of a robot."""

from __future__ import annotations

from typing import Any

from ...world.robot import EPUCK, EPUCK2, RobotGeometry

GEOMETRIES = {geometry.name: geometry for geometry in (EPUCK, EPUCK2)}


def robot_content(geometry: RobotGeometry) -> dict[str, Any]:
    """Sizes and sensors, lengths in m, angles in rad."""
    return {
        "name": geometry.name,
        "radius": geometry.body_radius,
        "angles": list(geometry.infrared_angles),
        "range": geometry.infrared_range,
        "maxSpeed": geometry.max_speed,
    }
