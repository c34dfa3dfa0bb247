from __future__ import annotations

import math

import pytest
from tolman.agent import GoalError
from tolman.agent.goals import Foray
from tolman.behaviors.foray import ForayBehavior, Foraying
from tolman.plugins.testing import Trial, assert_drives_forward, assert_in_place, assert_states, percept


def test_it_turns_then_crosses_then_arrives() -> None:
    trial = Trial(ForayBehavior(), goal=Foray(turn=math.radians(90.0)))
    assert_in_place(trial.step())
    trial.run(ticks=150)
    assert_drives_forward(trial.proposals[-1])
    assert trial.pose.heading == pytest.approx(math.radians(90.0), abs=0.02)
    trial.step(percept(front=0.015))
    assert trial.behavior.succeeded
    assert trial.behavior.result == pytest.approx(trial.pose.y, abs=0.002)
    assert_states(trial.states, Foraying.TURNING, Foraying.CROSSING, Foraying.ARRIVED)


def test_the_wall_it_starts_beside_does_not_end_it() -> None:
    trial = Trial(ForayBehavior(), goal=Foray())
    trial.run(percept(right=0.006), ticks=10)
    assert not trial.behavior.finished


def test_a_wall_met_at_a_slant_ends_it() -> None:
    trial = Trial(ForayBehavior(), goal=Foray())
    trial.run(ticks=80)
    trial.step(percept(left=0.004))
    assert trial.behavior.succeeded


def test_it_gives_up_where_no_wall_comes() -> None:
    trial = Trial(ForayBehavior(), goal=Foray(max_distance=0.2))
    trial.run(ticks=300)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert trial.behavior.reason == "no wall within 0.2 m"
    assert trial.pose.x == pytest.approx(0.2, abs=0.005)


def test_a_goal_that_leads_nowhere_is_refused() -> None:
    with pytest.raises(GoalError, match="foray: goal: turn must be a finite number, not nan"):
        Trial(ForayBehavior(), goal=Foray(turn=math.nan))
    with pytest.raises(GoalError, match="foray: goal: max_distance must be above 0, not 0"):
        Trial(ForayBehavior(), goal={"max_distance": 0})
