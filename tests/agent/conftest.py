"""What the infrared sensors sense, without noise, between straight walls at any angle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import pytest
from tolman.agent.perception.infrared import raw_value
from tolman.world.robot import EPUCK, Percept

Wall = tuple[float, float]
"""(direction from the robot to the wall's foot in rad, its distance from the center in m)."""


def _between(walls: Iterable[Wall], heading: float = 0.0) -> Percept:
    values = []
    for angle in EPUCK.infrared_angles:
        reach = math.inf
        for normal, distance in walls:
            part = math.cos(angle + heading - normal)
            if part > 1e-6:
                reach = min(reach, distance / part)
        values.append(raw_value(EPUCK, reach - EPUCK.body_radius))
    return Percept(0, 0.0, tuple(values), (0.0, 0.0))


@pytest.fixture(scope="session")
def between() -> Callable[..., Percept]:
    """`between([(normal, distance), ...], heading)`: the percept with these walls around."""
    return _between
