from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.perception.infrared import raw_value
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.plugins.testing import Trial, assert_in_place, assert_states, assert_turns, percept
from tolman.world.robot import EPUCK, Percept

STATES = ObstacleAvoidance.States


@pytest.mark.parametrize("sensed", [percept(left=0.015), percept(right=0.015)])
def test_it_is_silent_beside_a_wall_at_following_distance(sensed: Percept) -> None:
    assert Trial(ObstacleAvoidance()).step(sensed) is None


def test_it_is_silent_at_a_concave_corner_where_a_node_is_made() -> None:
    assert Trial(ObstacleAvoidance()).step(percept(right=0.022, front=0.015)) is None


def tilted(bearing: float, gap: float) -> Percept:
    """A single wall whose normal stands at `bearing` (rad) from the robot's heading, `gap` m from the rim."""
    radius = EPUCK.body_radius
    values = []
    for angle in EPUCK.infrared_angles:
        part = math.cos(angle - bearing)
        values.append(raw_value(EPUCK, (radius + gap) / part - radius) if part > 0.0 else 0.0)
    return Percept(tick=0, time=0.0, infrared=tuple(values), encoders=(0.0, 0.0))


@pytest.mark.parametrize(("bearing", "side"), [(-0.4, "left"), (0.4, "right")])
def test_it_turns_in_place_away_from_what_is_too_close(bearing: float, side: str) -> None:
    proposal = Trial(ObstacleAvoidance()).step(tilted(bearing, 0.003))
    assert_turns(proposal, side)
    assert_in_place(proposal)


def test_it_turns_though_a_wall_straight_ahead_cancels_the_sum() -> None:
    trial = Trial(ObstacleAvoidance())
    assert_turns(trial.step(percept(front=0.003)), "left")


def test_it_keeps_the_side_until_there_is_room() -> None:
    trial = Trial(ObstacleAvoidance())
    trial.run([tilted(-0.4, 0.003), tilted(0.3, 0.004), percept(front=0.05)])
    assert_turns(trial.proposals[1], "left")
    assert trial.proposals[2] is None
    assert_states(trial.states, STATES.CLEAR, STATES.TURNING_LEFT, STATES.CLEAR)


def test_it_ends_only_when_there_is_more_room_than_what_woke_it() -> None:
    trial = Trial(ObstacleAvoidance())
    assert trial.step(percept(front=0.009)) is None
    trial.step(percept(front=0.006))
    assert trial.step(percept(front=0.009)) is not None
    assert trial.step(percept(front=0.014)) is None


@given(st.floats(-0.9, 0.9), st.floats(0.0, 0.003))
def test_it_wakes_at_any_wall_it_is_about_to_hit_and_never_moves_ahead(bearing: float, gap: float) -> None:
    proposal = Trial(ObstacleAvoidance()).step(tilted(bearing, gap))
    assert_in_place(proposal)
    assert proposal is not None
    assert proposal.command.left != 0.0
