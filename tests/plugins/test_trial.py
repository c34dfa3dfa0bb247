from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from tolman.agent.events import BehaviorStarted, Lost
from tolman.behaviors.wander import Wander
from tolman.plugins.testing import (
    ScriptedRobot,
    Trial,
    assert_event_order,
    assert_states,
    assert_turns,
    assert_valid,
    percept,
)
from tolman.plugins.testing.strategies import percept_runs, percepts, wall_percepts
from tolman.world.robot import EPUCK, LEFT, RIGHT, RIGHT_FRONT, Percept, WheelCommand


def test_a_wall_on_the_right_is_sensed_at_its_distance_on_the_right_alone() -> None:
    sensed = percept(right=0.02)
    assert EPUCK.infrared_distance(sensed.infrared[RIGHT]) == pytest.approx(0.02, abs=1e-4)
    assert sensed.infrared[LEFT] == 0.0


def test_a_wall_ahead_is_sensed_farther_along_a_slanting_ray() -> None:
    sensed = percept(front=0.02)
    along = (0.035 + 0.02) / np.cos(0.30) - 0.035
    assert EPUCK.infrared_distance(sensed.infrared[RIGHT_FRONT]) == pytest.approx(along, abs=1e-6)


def test_a_scripted_robot_goes_through_its_list_and_stays_at_the_end() -> None:
    robot = ScriptedRobot([percept(front=0.01), percept(right=0.01)])
    seen = []
    for _ in range(3):
        seen.append(robot.sense())
        assert robot.sense() == seen[-1]
        robot.act(WheelCommand(0.0, 0.0))
    assert [sensed.tick for sensed in seen] == [0, 1, 2]
    assert seen[1].infrared == seen[2].infrared != seen[0].infrared
    assert robot.exhausted


def test_a_scripted_robots_encoders_follow_its_commands() -> None:
    robot = ScriptedRobot()
    robot.act(WheelCommand(100.0, 5000.0))
    assert robot.sense().encoders == pytest.approx((3.2, 32.0))


def test_a_scripted_robot_refuses_what_is_not_finite_and_images_it_has_not() -> None:
    with pytest.raises(ValueError, match="must be finite"):
        ScriptedRobot().act(WheelCommand(float("nan"), 0.0))
    with pytest.raises(ValueError, match="asked for 16 x 16"):
        ScriptedRobot(image=np.zeros((8, 8), dtype=np.float32)).look()


def test_a_trial_integrates_what_was_proposed() -> None:
    trial = Trial(Wander(leg=100.0))
    trial.run(ticks=11)
    assert trial.pose.x == pytest.approx(10 * 0.032 * 300.0 * EPUCK.distance_per_step)


def test_assertions_fail_with_what_was_there() -> None:
    trial = Trial(Wander())
    with pytest.raises(AssertionError, match="expected a turn to the left"):
        assert_turns(trial.step(), "left")
    with pytest.raises(AssertionError, match="expected the states TURNING, saw STRAIGHT"):
        assert_states(trial.states, Wander.States.TURNING)
    with pytest.raises(AssertionError, match="expected a Proposal"):
        assert_valid(None)
    events = [Lost(time=0.0, reason=""), BehaviorStarted(time=1.0, behavior="a")]
    assert_event_order(events, Lost, BehaviorStarted)
    with pytest.raises(AssertionError, match="event 2, Lost, is missing"):
        assert_event_order(events, BehaviorStarted, Lost)


@given(percepts())
def test_any_percept_keeps_the_format(sensed: Percept) -> None:
    assert len(sensed.infrared) == 8
    assert all(0.0 <= value <= 4095.0 for value in sensed.infrared)


@given(wall_percepts(most=0.05))
def test_percepts_of_walls_keep_the_format(sensed: Percept) -> None:
    assert all(0.0 <= value <= 4095.0 for value in sensed.infrared)


@given(percept_runs(max_size=5))
def test_wander_is_sane_on_any_run(run: list[Percept]) -> None:
    trial = Trial(Wander())
    for sensed in run:
        assert_valid(trial.step(sensed))


def test_fixtures_of_the_same_names_come_with_pytest(
    percept: object, trial: object, scripted_robot: object, check_plugin: object
) -> None:
    assert all(map(callable, (percept, trial, scripted_robot, check_plugin)))


def test_the_kit_and_a_behavior_load_no_simulator() -> None:
    code = (
        "import sys, tolman.plugins.testing, tolman.behaviors.wander\n"
        "print([m for m in ('dartpy', 'embreex', 'matplotlib', 'yaml') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
