from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, CornerReached, Event
from tolman.agent.goals import ReacquireCorner
from tolman.behaviors.position_correction import Correcting, PositionCorrection
from tolman.plugins.testing import Trial, assert_in_place, assert_valid, event_of, percept
from tolman.plugins.testing.strategies import percept_runs
from tolman.world import open_world
from tolman.world.robot import EPUCK, Percept, Pose, wrap_angle

GAP = 0.057 - EPUCK.body_radius
CONCAVE, CONVEX = Pose(0.943, 0.057, 0.0), Pose(0.643, 0.603, math.pi)
"""Two of env1's nodes with the wall on the right, in the heading of the wall that led there."""


def corrected(
    node: Pose, kind: str, off: Pose, noise: str, seed: int = 0
) -> tuple[BehaviorFinished, Pose, int]:
    """Stands off the node by `off` (node's frame); how it ended, the true error, collisions."""
    start = node.compose(off.x, off.y, off.heading)
    world = open_world("env1", engine="kinematic", noise=noise, seed=seed, start=start)
    agent, heard = Agent(world.robots[0], [PositionCorrection()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("position-correction", ReacquireCorner("right", kind, 0.25))
    for _ in range(2000):
        agent.tick()
        world.step()
        if not agent.is_active("position-correction"):
            break
    return event_of(heard, BehaviorFinished), node.relative(world.true_pose()), world.collisions()


@pytest.mark.parametrize(
    "off",
    [
        Pose(0.0, 0.0, 0.0),
        Pose(-0.008, 0.004, math.radians(6.0)),
        Pose(0.005, 0.006, math.radians(-4.0)),
        Pose(-0.006, -0.004, math.radians(4.0)),
    ],
)
@pytest.mark.parametrize(("node", "kind"), [(CONCAVE, "concave"), (CONVEX, "convex")])
def test_it_comes_back_to_the_corner_from_a_centimeter_and_some_degrees_off(
    node: Pose, kind: str, off: Pose
) -> None:
    finished, error, collisions = corrected(node, kind, off, "none")
    assert finished.succeeded
    assert isinstance(finished.result, CornerReached)
    assert finished.result.kind == kind
    assert math.hypot(error.x, error.y) < 0.0025
    assert abs(error.heading) < math.radians(2.0)
    assert collisions == 0


def test_noise_leaves_it_within_four_millimeters() -> None:
    off = Pose(-0.006, 0.005, math.radians(-4.0))
    runs = [corrected(CONCAVE, "concave", off, "thesis", seed) for seed in range(4)]
    assert all(finished.succeeded for finished, _, _ in runs)
    assert max(math.hypot(error.x, error.y) for _, error, _ in runs) < 0.004


def test_it_turns_parallel_to_the_wall_then_backs_off() -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("right", "concave", 0.3))
    trial.run(percept(right=GAP), ticks=9)
    for proposal in trial.proposals[:8]:
        assert_in_place(proposal)
    trial.run(percept(right=GAP), ticks=60)
    assert trial.behavior.state is Correcting.BACK
    assert trial.pose.x < -0.03


def test_it_never_backs_off_farther_than_the_wall_leads_back() -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("left", "concave", 0.05))
    least = 0.0
    for _ in range(150):
        trial.step(percept(left=GAP))
        least = min(least, trial.pose.x)
    assert least == pytest.approx(-0.05, abs=0.003)


def test_something_behind_ends_the_backing() -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("right", "concave", 0.3))
    trial.run(percept(right=GAP), ticks=30)
    trial.step(percept(right=GAP, rear=0.004))
    assert trial.behavior.state is Correcting.MEASURE_AGAIN


def test_without_a_corner_it_gives_up() -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("right", "concave", 0.05))
    trial.run(percept(right=GAP), ticks=400)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert "no corner within" in trial.behavior.reason


def test_another_kind_of_corner_is_a_failure_that_says_so() -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("right", "convex", 0.05))
    trial.run(percept(right=GAP), ticks=100)
    trial.run(percept(right=GAP, front=GAP - 0.002), ticks=6)
    assert (trial.behavior.finished, trial.behavior.succeeded) == (True, False)
    assert "met a concave corner" in trial.behavior.reason


@settings(max_examples=50, deadline=None)
@given(percept_runs())
def test_whatever_is_sensed_its_proposals_are_valid(run: list[Percept]) -> None:
    trial = Trial(PositionCorrection(), goal=ReacquireCorner("left", "convex", 0.2))
    for sensed in run:
        if not trial.behavior.finished:
            assert_valid(trial.step(sensed))


def test_only_a_return_to_corner_goal_is_taken() -> None:
    with pytest.raises(TypeError, match="needs a ReacquireCorner goal, not 7"):
        Trial(PositionCorrection(), goal=7)


def test_headings_are_compared_the_short_way_around() -> None:
    assert abs(wrap_angle(CONVEX.heading + math.pi)) < 1e-9
