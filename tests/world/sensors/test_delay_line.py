from __future__ import annotations

import pytest
from tolman.world import Pose, Timing, WheelCommand, open_world

from ..arrangements import SQUARE


def test_a_delayed_sensor_lags_and_a_slow_one_repeats() -> None:
    sensing = {"infrared": Timing(interval=0.096), "encoders": Timing(delay=0.064)}
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.9, 1.0, 0.0), sensing=sensing)
    robot = world.robots[0]
    encoders, infrared = [], []
    for _ in range(9):
        robot.act(WheelCommand(100, 100))
        world.step()
        encoders.append(robot.sense().encoders[0] / 3.2)
        infrared.append(robot.sense().infrared[0])
    assert encoders == pytest.approx([0, 0, 1, 2, 3, 4, 5, 6, 7])
    assert infrared[2] == infrared[3] == infrared[4] != infrared[5]
