from __future__ import annotations

import math

import pytest
from tolman.world import EPUCK, Pose, WheelCommand, open_world


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused(speed: float) -> None:
    world = open_world("env1", engine="kinematic")
    with pytest.raises(ValueError, match="finite"):
        world.robots[0].act(WheelCommand(speed, 0.0))


def test_commands_are_clamped_to_the_robots_top_speed() -> None:
    world = open_world("env1", engine="kinematic", noise="none", start=Pose(0.15, 0.3, math.pi / 2))
    world.robots[0].act(WheelCommand(1e9, 1e9))
    world.step()
    assert world.true_pose().y - 0.3 == pytest.approx(EPUCK.max_speed * EPUCK.distance_per_step * 0.032)
