from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent import Agent
from tolman.agent.estimation.local_filter import LocalPose
from tolman.agent.events import BehaviorFinished
from tolman.agent.goals import DrivePath, PlacesDriven
from tolman.agent.walls import walls_at
from tolman.behaviors.local_go_to import LocalGoing, LocalGoTo
from tolman.plugins.testing import Trial, assert_states, assert_valid, percept
from tolman.plugins.testing.strategies import percept_runs
from tolman.world import open_world
from tolman.world.robot import Percept, Pose, wrap_angle

places = st.tuples(st.floats(-0.12, 0.12), st.floats(-0.12, 0.12))


@settings(max_examples=25, deadline=None)
@given(st.lists(places, min_size=1, max_size=4), st.floats(-3.0, 3.0))
def test_in_the_open_it_comes_by_every_place_and_ends_in_the_heading(
    way: list[tuple[float, float]], heading: float
) -> None:
    trial = Trial(LocalGoTo(), goal=DrivePath(tuple(way), heading=heading))
    nearest = [math.inf] * len(way)
    for _ in range(3000):
        if trial.behavior.finished:
            break
        assert_valid(trial.step())
        away = [math.hypot(trial.pose.x - x, trial.pose.y - y) for x, y in way]
        nearest = [min(pair) for pair in zip(nearest, away, strict=True)]
    assert trial.behavior.succeeded
    assert max(nearest) < 0.004
    result = trial.behavior.result
    assert isinstance(result, PlacesDriven)
    assert result.reached == len(way)
    assert math.hypot(result.pose.x - way[-1][0], result.pose.y - way[-1][1]) < 0.004
    assert abs(wrap_angle(result.pose.heading - heading)) < 0.01


def test_places_are_in_the_frame_that_has_its_start() -> None:
    """It stands at (0.1, 0) facing +y: the place (0.1, 0.05) is straight ahead."""
    trial = Trial(LocalGoTo(), goal=DrivePath(((0.1, 0.05),), start=(0.1, 0.0, 0.5 * math.pi)))
    trial.run(ticks=200)
    assert trial.behavior.succeeded
    assert trial.pose.x == pytest.approx(0.05, abs=0.003)
    assert trial.pose.y == pytest.approx(0.0, abs=0.003)
    assert trial.behavior.result.pose.y == pytest.approx(0.05, abs=0.003)


def test_a_way_that_is_blocked_from_the_start_is_given_up_without_driving() -> None:
    trial = Trial(LocalGoTo(), goal=DrivePath(((0.08, 0.0),)))
    trial.run(percept(front=0.02), ticks=5)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert trial.behavior.reason == "the way to place 0 is blocked"
    assert trial.behavior.result.reached == 0
    assert trial.pose.x == pytest.approx(0.0, abs=1e-6)


def test_an_obstacle_on_the_way_sends_it_back_to_the_place_before() -> None:
    trial = Trial(LocalGoTo(), goal=DrivePath(((0.05, 0.0), (0.12, 0.0))))
    while trial.behavior.result is None and trial.pose.x < 0.07:
        trial.step()
    trial.step(percept(front=0.002))
    trial.run(ticks=100)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert trial.behavior.reason == "an obstacle on the way to place 1"
    assert trial.behavior.result.reached == 1
    assert trial.pose.x == pytest.approx(0.05, abs=0.003)
    assert trial.states[-1] is LocalGoing.RETREAT


def test_without_a_heading_it_ends_as_it_arrives() -> None:
    trial = Trial(LocalGoTo(), goal=DrivePath(((0.0, 0.05),)))
    trial.run(ticks=200)
    assert trial.behavior.succeeded
    assert trial.pose.heading == pytest.approx(0.5 * math.pi, abs=0.02)
    assert_states(trial.states, LocalGoing.AIM, LocalGoing.DRIVE, LocalGoing.AIM, LocalGoing.FACE)


@settings(max_examples=50, deadline=None)
@given(percept_runs())
def test_whatever_is_sensed_its_proposals_are_valid(run: list[Percept]) -> None:
    trial = Trial(LocalGoTo(), goal=DrivePath(((0.05, 0.02), (0.0, 0.0))))
    for sensed in run:
        if not trial.behavior.finished:
            assert_valid(trial.step(sensed))


def driven(landmarks: bool, seed: int) -> tuple[Pose, Pose]:
    """Twice round in a corner of env1 with noise, then home: where it is, where it holds itself to be."""
    node = Pose(0.943, 0.057, 0.0)
    world = open_world("env1", engine="kinematic", noise="thesis", seed=seed, start=node)
    agent, heard = Agent(world.robots[0], [LocalGoTo()]), list[BehaviorFinished]()
    agent.bus.subscribe(BehaviorFinished, heard.append)
    pose = LocalPose(square=True)
    pose.know_corner("concave", walls_at("right", "concave", square=True, distance=0.057))
    round_ = ((-0.04, 0.0), (-0.08, 0.04), (-0.04, 0.08), (0.0, 0.04), (0.0, 0.0))
    by_walls = DrivePath(round_ * 2, belief=pose.belief(), heading=0.0, fix=True)
    agent.start("local-go-to", by_walls if landmarks else DrivePath(round_ * 2, heading=0.0))
    for _ in range(8000):
        agent.tick()
        world.step()
        if heard:
            return node.relative(world.true_pose()), heard[0].result.pose
    raise AssertionError("not home after 8000 ticks")


def test_walls_known_beforehand_keep_its_pose_where_path_integration_alone_drifts() -> None:
    with_walls, without = ([driven(kept, seed) for seed in range(4)] for kept in (True, False))

    def worst(runs: list[tuple[Pose, Pose]]) -> tuple[float, float]:
        return (
            max(true.distance_to(held) for true, held in runs),
            max(abs(wrap_angle(true.heading - held.heading)) for true, held in runs),
        )

    assert worst(with_walls)[0] < 0.004
    assert worst(with_walls)[1] < math.radians(2.0)
    assert worst(without)[1] > 2.0 * worst(with_walls)[1]


def test_only_a_go_through_goal_is_taken() -> None:
    with pytest.raises(TypeError, match="needs a DrivePath goal"):
        Trial(LocalGoTo(), goal=((0.0, 0.0),))
