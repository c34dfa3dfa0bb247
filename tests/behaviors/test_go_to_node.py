from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, Event, NodePassed
from tolman.agent.goals import FollowFrom, GoAlong, Leg
from tolman.behaviors.go_to_node import Going, GoToNode
from tolman.plugins.testing import (
    Trial,
    assert_in_place,
    assert_states,
    assert_turns,
    assert_valid,
    event_of,
    percept,
)
from tolman.plugins.testing.strategies import percept_runs
from tolman.world import open_world
from tolman.world.robot import EPUCK, Percept, Pose, wrap_angle

GAP = 0.057 - EPUCK.body_radius
QUARTER = 0.5 * math.pi
ONWARD = (
    Leg(0, 1, "right", 0.546, "concave", 0.0, FollowFrom.CONCAVE, QUARTER),
    Leg(1, 2, "right", 0.300, "convex"),
    Leg(2, 3, "right", 0.340, "concave"),
)
"""env1: from the corner (0.943, 0.057) by (0.943, 0.603) and (0.643, 0.603) to (0.643, 0.943)."""


def trip(
    start: Pose, goal: GoAlong, noise: str, seed: int = 0, **config: Any
) -> tuple[BehaviorFinished, Pose, list[int], int]:
    """How it ended, the true pose at the end, the nodes passed, collisions."""
    world = open_world("env1", engine="kinematic", noise=noise, seed=seed, start=start)
    agent, heard = Agent(world.robots[0], [GoToNode(**config)]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("go-to-node", goal)
    for _ in range(4000):
        agent.tick()
        world.step()
        if not agent.is_active("go-to-node"):
            break
    passed = [event.node for event in heard if isinstance(event, NodePassed)]
    return event_of(heard, BehaviorFinished), world.true_pose(), passed, world.collisions()


@pytest.mark.parametrize(("noise", "limit"), [("none", 0.002), ("thesis", 0.005)])
def test_it_drives_leg_after_leg_and_stands_at_the_node_in_the_heading_of_its_wall(
    noise: str, limit: float
) -> None:
    finished, pose, passed, collisions = trip(Pose(0.943, 0.057, 0.0), GoAlong(ONWARD), noise)
    assert finished.succeeded
    assert passed == [1, 2, 3]
    assert math.hypot(pose.x - 0.643, pose.y - 0.943) < limit
    assert abs(wrap_angle(pose.heading - QUARTER)) < math.radians(3.0)
    assert [(leg.source, leg.target) for leg in finished.result] == [(0, 1), (1, 2), (2, 3)]
    assert all(leg.recognized for leg in finished.result)
    for leg, driven in zip(ONWARD, finished.result, strict=True):
        assert driven.distance == pytest.approx(leg.distance, abs=0.02)
    assert collisions == 0


def test_back_it_turns_around_follows_with_the_other_hand_and_faces_as_told() -> None:
    back = Leg(1, 0, "left", 0.546, "concave", math.pi, FollowFrom.WALL)
    finished, pose, passed, _ = trip(Pose(0.943, 0.603, QUARTER), GoAlong((back,), QUARTER), "none")
    assert finished.succeeded
    assert passed == [0]
    assert math.hypot(pose.x - 0.943, pose.y - 0.057) < 0.002
    assert abs(wrap_angle(pose.heading)) < math.radians(2.0)


def test_a_corner_that_does_not_come_in_time_is_given_up_with_the_reason() -> None:
    short = Leg(0, 1, "right", 0.2, "concave", 0.0, FollowFrom.CONCAVE, QUARTER)
    finished, _, passed, _ = trip(Pose(0.943, 0.057, 0.0), GoAlong((short,)), "none")
    assert not finished.succeeded
    assert passed == []
    assert finished.result == ()
    assert finished.reason == "no concave corner within 0.25 m after node 0"


def test_another_kind_of_corner_in_its_place_is_given_up_with_the_reason() -> None:
    wrong = Leg(0, 1, "right", 0.546, "convex", 0.0, FollowFrom.CONCAVE, QUARTER)
    finished, _, _, _ = trip(Pose(0.943, 0.057, 0.0), GoAlong((wrong,)), "none")
    assert not finished.succeeded
    assert "expected a convex corner 0.55 m after node 0, met a concave one" in finished.reason


def test_a_corner_met_too_early_is_driven_through() -> None:
    """A leg that skips env1's corner at (0.943, 0.603): the way is as long, its end of the right kind."""
    skipping = Leg(0, 2, "right", 0.846, "convex", 0.0, FollowFrom.CONCAVE, QUARTER)
    finished, pose, passed, _ = trip(Pose(0.943, 0.057, 0.0), GoAlong((skipping,)), "none")
    assert finished.succeeded
    assert passed == [2]
    assert math.hypot(pose.x - 0.643, pose.y - 0.603) < 0.003


def test_without_recognizing_corners_every_arc_ends_after_its_length() -> None:
    """A last leg 20 cm long ends 20 cm along its wall; those before it at their lengths, not 2 mm sooner."""
    legs = (*ONWARD[:2], Leg(2, 3, "right", 0.200, "concave"))
    start = Pose(0.943, 0.057, 0.0)
    finished, pose, passed, _ = trip(start, GoAlong(legs), "none", recognize=False)
    assert finished.succeeded
    assert passed == [1, 2, 3]
    assert not any(leg.recognized for leg in finished.result)
    assert sum(leg.distance for leg in finished.result) == pytest.approx(1.046, abs=0.005)
    assert math.hypot(pose.x - 0.643, pose.y - 0.803) < 0.02


def test_a_blunt_corner_that_is_not_met_is_passed_by_its_path_and_the_next_one_found() -> None:
    """A node 20 cm along the first wall, at a corner that this wall has not."""
    legs = (
        Leg(0, 7, "right", 0.2, "concave", 0.0, FollowFrom.CONCAVE, QUARTER, blunt=True),
        Leg(7, 1, "right", 0.346, "concave"),
        ONWARD[1],
    )
    finished, pose, passed, _ = trip(Pose(0.943, 0.057, 0.0), GoAlong(legs), "none")
    assert finished.succeeded
    assert passed == [7, 1, 2]
    assert [leg.recognized for leg in finished.result] == [False, True, True]
    assert math.hypot(pose.x - 0.643, pose.y - 0.603) < 0.003


@pytest.mark.parametrize("early", [0.02, -0.02])
def test_a_bend_mapped_beside_a_corner_is_no_matter_on_whichever_side_it_is_felt(early: float) -> None:
    """The bend's way is 2 cm too short or too long: too long, the corner comes first."""
    legs = (
        Leg(0, 7, "right", 0.546 - early, "none", 0.0, FollowFrom.CONCAVE, QUARTER),
        Leg(7, 1, "right", max(0.0, early), "concave"),
        ONWARD[1],
    )
    finished, pose, passed, _ = trip(Pose(0.943, 0.057, 0.0), GoAlong(legs), "none")
    assert finished.succeeded
    assert passed == [7, 1, 2]
    assert math.hypot(pose.x - 0.643, pose.y - 0.603) < 0.003


def test_a_trip_to_where_it_stands_is_done_with_the_last_turn() -> None:
    trial = Trial(GoToNode(), goal=GoAlong((), face=-1.0))
    trial.run(ticks=150)
    assert trial.behavior.succeeded
    assert trial.behavior.result == ()
    assert trial.pose.heading == pytest.approx(-1.0, abs=0.01)
    assert_states(trial.states, Going.DEPART, Going.FACE)


def test_it_turns_around_in_place_before_a_leg_back() -> None:
    trial = Trial(GoToNode(), goal=GoAlong((Leg(1, 0, "left", 0.5, "concave", math.pi, FollowFrom.WALL),)))
    trial.step(percept(left=GAP))
    for _ in range(10):
        proposal = trial.step()
        assert_in_place(proposal)
        assert_turns(proposal, "left")
    assert trial.behavior.state is Going.TURN


@settings(max_examples=50, deadline=None)
@given(percept_runs())
def test_whatever_is_sensed_its_proposals_are_valid(run: list[Percept]) -> None:
    trial = Trial(GoToNode(), goal=GoAlong(ONWARD))
    for sensed in run:
        if not trial.behavior.finished:
            assert_valid(trial.step(sensed))


def test_only_a_go_along_goal_is_taken() -> None:
    with pytest.raises(TypeError, match="needs a GoAlong goal, not 'home'"):
        Trial(GoToNode(), goal="home")
