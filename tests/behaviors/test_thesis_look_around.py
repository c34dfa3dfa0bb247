"""Looking around: four views in order, back where it pointed, or a turn alone."""

import math
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished
from tolman.agent.goals import LookAround
from tolman.behaviors.look_around import LookAroundBehavior
from tolman.world import open_world
from tolman.world.robot import Pose, wrap_angle


def look(goal: LookAround, heading: float = 0.3) -> tuple[Any, Pose, Any]:
    """The result, where the robot then points, and what the camera sees in the four directions."""
    world = open_world("env1", noise="none", engine="kinematic", start=Pose(0.6, 0.2, heading))
    agent = Agent(world.robots[0], [LookAroundBehavior()])
    finished: list[BehaviorFinished] = []
    agent.bus.subscribe(BehaviorFinished, finished.append)
    agent.start("look-around", goal)
    for _ in range(1000):
        agent.tick()
        world.step()
        if finished:
            break
    pose = world.true_pose()
    seen = []
    for quarter in range(4):
        world.place(Pose(pose.x, pose.y, heading + goal.turn + 0.5 * math.pi * quarter))
        seen.append(world.robots[0].look())
    return finished[0].result, pose, np.array(seen)


def test_the_views_are_ahead_left_behind_and_right() -> None:
    views, pose, seen = look(LookAround())
    assert views.shape == (4, 16, 16)
    assert np.abs(views - seen).mean() < 0.02
    assert abs(wrap_angle(pose.heading - 0.3)) < 0.02


def test_it_turns_before_it_looks() -> None:
    views, pose, seen = look(LookAround(math.pi))
    assert np.abs(views - seen).mean() < 0.02
    assert abs(wrap_angle(pose.heading - 0.3 - math.pi)) < 0.03


def test_without_views_it_only_turns() -> None:
    views, pose, _ = look(LookAround(-1.0, views=False))
    assert views is None
    assert pose.heading == pytest.approx(-0.7, abs=0.01)


def test_it_refuses_another_goal() -> None:
    with pytest.raises(TypeError, match="needs a LookAround goal"):
        LookAroundBehavior().start(1.0, None)  # type: ignore[arg-type]
