from __future__ import annotations

import math

import pytest
from tolman.agent import Agent
from tolman.agent.events import BehaviorFaulted, BehaviorFinished, Event
from tolman.agent.goals import AlignToWall
from tolman.behaviors.align_to_wall import Aligning, AlignToWallBehavior
from tolman.plugins.testing import Trial, assert_stands, assert_states, event_of, percept
from tolman.world import open_world
from tolman.world.robot import Pose


def aligned(side: str, tilt: float, seed: int, noise: str) -> tuple[BehaviorFinished, float]:
    """Stands beside env1's lower wall (parallel to the x axis); returns how it ended and how wrong."""
    heading = 0.0 if side == "right" else math.pi
    start = Pose(0.65, 0.055, heading + tilt)
    world = open_world("env1", engine="kinematic", noise=noise, seed=seed, start=start)
    agent, heard = Agent(world.robots[0], [AlignToWallBehavior()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("align-to-wall", AlignToWall(side))
    for _ in range(1000):
        agent.tick()
        world.step()
        if not agent.is_active("align-to-wall"):
            break
    agent.tick()
    assert not any(isinstance(event, BehaviorFaulted) for event in heard)
    return event_of(heard, BehaviorFinished), math.remainder(world.true_pose().heading - heading, math.tau)


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("tilt", [-0.3, 0.02, 0.25])
def test_it_ends_parallel_to_the_wall(side: str, tilt: float) -> None:
    finished, error = aligned(side, tilt, seed=0, noise="none")
    assert finished.succeeded
    assert abs(error) < math.radians(2.5)


def test_noise_leaves_it_within_a_few_degrees() -> None:
    errors = [aligned("right", 0.2, seed, "thesis") for seed in range(5)]
    assert all(finished.succeeded for finished, _ in errors)
    assert max(abs(error) for _, error in errors) < math.radians(6.0)


def test_it_stands_while_it_measures_and_gives_up_without_a_wall() -> None:
    trial = Trial(AlignToWallBehavior(), goal=AlignToWall("left"))
    trial.run(ticks=12)
    for proposal in trial.proposals:
        assert_stands(proposal)
    assert trial.behavior.finished
    assert not trial.behavior.succeeded
    assert trial.behavior.reason == "no wall at the side"


def test_beside_a_parallel_wall_it_does_not_turn() -> None:
    trial = Trial(AlignToWallBehavior(), goal=AlignToWall("right"))
    trial.run(percept(right=0.022), ticks=12)
    assert trial.behavior.succeeded
    assert_states(trial.states, Aligning.MEASURING)


def test_another_goal_is_refused() -> None:
    with pytest.raises(TypeError, match="needs an AlignToWall goal, not 3"):
        Trial(AlignToWallBehavior(), goal=3)
