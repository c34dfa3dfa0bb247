from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, Event
from tolman.agent.goals import Dock
from tolman.behaviors.dock import DockBehavior
from tolman.plugins.testing import Trial, event_of, percept
from tolman.world import open_world
from tolman.world.robot import Pose, wrap_angle


@settings(max_examples=20)
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-3.0, 3.0))
def test_in_the_open_it_comes_to_rest_in_the_pose(x: float, y: float, heading: float) -> None:
    trial = Trial(DockBehavior(), goal=Dock(Pose(x, y, heading)))
    trial.run(ticks=600)
    assert trial.behavior.succeeded
    assert trial.pose.distance_to(Pose(x, y)) < 0.003
    assert abs(wrap_angle(trial.pose.heading - heading)) < 0.02


def test_walls_trim_what_path_integration_got_wrong() -> None:
    true = Pose(0.42 + 0.070, 0.060, math.pi + 0.12)
    world = open_world("env1", engine="kinematic", noise="none", start=true)
    agent, heard = Agent(world.robots[0], [DockBehavior()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("dock", Dock(Pose(), side="left", wall_ahead=0.057))
    for _ in range(800):
        agent.tick()
        world.step()
    assert event_of(heard, BehaviorFinished).succeeded
    assert world.true_pose().x == pytest.approx(0.42 + 0.057, abs=0.003)
    assert abs(wrap_angle(world.true_pose().heading - math.pi)) < math.radians(3.0)


def test_a_blocked_way_is_given_up() -> None:
    trial = Trial(DockBehavior(), goal=Dock(Pose(0.1, 0.0, 0.0)))
    trial.run(percept(front=0.01), ticks=5)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert "blocked" in trial.behavior.reason
