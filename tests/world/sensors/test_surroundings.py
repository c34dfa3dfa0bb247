from __future__ import annotations

import numpy as np
import pytest
from tolman.world import EPUCK2, Pose, WheelCommand, WorldSpec, open_world
from tolman.world.spec import Box, MovableBox, room_walls

from ..arrangements import SQUARE


def test_robots_see_each_other_by_every_sensor() -> None:
    spec = WorldSpec("two", room_walls(2.0, 2.0), robots=(Pose(1.1, 1.0, 0.0),))
    world = open_world(spec, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0), geometry=EPUCK2)
    alone = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0), geometry=EPUCK2)
    assert world.robots[0].sense().infrared[0] > 120
    assert not np.array_equal(world.robots[0].look(), alone.robots[0].look())
    assert world.robots[0].sense().readings["range"][0] == pytest.approx(
        0.1 - 2 * EPUCK2.body_radius, abs=1e-3
    )
    assert alone.robots[0].sense().readings["range"][0] == pytest.approx(1.0 - EPUCK2.body_radius, abs=1e-3)


def test_a_box_that_was_pushed_is_seen_where_it_is_now() -> None:
    box = MovableBox(Box(1.1, 1.0, 0.06, 0.06))
    spec = WorldSpec("box", room_walls(2.0, 2.0), movable=(box,))
    robot = (world := open_world(spec, noise="none", start=Pose(1.0, 1.0, 0.0), geometry=EPUCK2)).robots[0]
    before = robot.look()
    world.place(Pose(0.9, 1.0, 0.0))
    for _ in range(150):
        robot.act(WheelCommand(500, 500))
        world.step()
    world.place(Pose(1.0, 1.0, 0.0))
    assert not np.array_equal(robot.look(), before)
    assert robot.sense().readings["range"][0] > 0.1
