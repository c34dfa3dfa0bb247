from __future__ import annotations

import pytest
from tolman.world import EPUCK, Pose, WheelCommand, open_world

from ..arrangements import SQUARE


def test_the_accelerometer_feels_gravity_and_the_start() -> None:
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 1.0))
    assert world.robots[0].sense().accelerometer == (0.0, 0.0, 9.81)
    world.robots[0].act(WheelCommand(500, 500))
    world.step()
    ahead, left, up = world.robots[0].sense().accelerometer
    assert ahead == pytest.approx(500 * EPUCK.distance_per_step / 0.032)
    assert left == pytest.approx(0.0, abs=1e-9)
    assert up == 9.81
    world.step()
    assert world.robots[0].sense().accelerometer[0] == pytest.approx(0.0, abs=1e-9)
