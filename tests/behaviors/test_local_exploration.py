from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from tolman.agent import Agent, GoalError
from tolman.agent.events import BehaviorFinished, Event
from tolman.agent.goals import ExploreLocally, LocalSamples
from tolman.agent.walls import walls_at
from tolman.behaviors.local_exploration import Exploring, LocalExploration
from tolman.plugins.testing import Trial, assert_valid, event_of, percept
from tolman.plugins.testing.strategies import percept_runs
from tolman.world import open_world
from tolman.world.robot import Image, Percept, Pose

NODE = Pose(0.943, 0.057, 0.0)
"""env1's first concave node: walls 5.7 cm to the right and ahead."""
WALLS = walls_at("right", "concave", square=True, distance=0.057)


def in_the_open(strategy: str, **settings: object) -> Trial:
    """Explores an empty plain; the camera sees in which direction it looks, as luminance."""
    trial = Trial(LocalExploration(**settings), goal=ExploreLocally(strategy))

    def look() -> Image:
        heading = math.remainder(trial.pose.heading, math.tau) / math.tau % 1.0
        return np.full((16, 16), heading, dtype=np.float32)

    trial.context.look = look
    for _ in range(20_000):
        if trial.behavior.finished:
            return trial
        trial.step()
    raise AssertionError(f"not done in 20000 ticks, in state {trial.behavior.state}")


@pytest.mark.parametrize("strategy", ["rows", "columns"])
def test_in_the_open_it_visits_every_place_and_comes_home(strategy: str) -> None:
    trial = in_the_open(strategy, rows=3, columns=3)
    samples = trial.behavior.result
    assert isinstance(samples, LocalSamples)
    assert trial.behavior.succeeded
    assert (samples.visited, samples.unreachable) == (9, 0)
    assert trial.pose.distance_to(Pose()) < 0.004
    assert abs(trial.pose.heading) < 0.01


def test_samples_are_as_far_apart_as_the_settings_say_and_cover_the_lattice() -> None:
    samples = in_the_open("rows", rows=3, columns=3, position_interval=0.02).behavior.result
    steps = np.hypot(*np.diff(samples.positions, axis=0).T)
    assert steps.min() >= 0.02 - 1e-9
    assert samples.positions.shape == (len(samples.positions), 2)
    span = samples.positions.max(axis=0) - samples.positions.min(axis=0)
    assert span == pytest.approx([2 * 0.05 * math.sqrt(0.75), 0.125], abs=0.03)


def test_the_four_views_are_ahead_left_behind_right_of_the_entry_heading() -> None:
    samples = in_the_open("rows", rows=3, columns=3, compass=False).behavior.result
    assert samples.panoramas.shape == (len(samples.panorama_positions), 4, 16, 16)
    assert len(samples.panoramas) >= 5
    assert samples.panorama_positions[0] == pytest.approx([0.0, 0.0], abs=1e-6)
    seen = samples.panoramas[:, :, 0, 0] - np.array([0.0, 0.25, 0.5, 0.75])
    assert np.abs((seen + 0.5) % 1.0 - 0.5).max() < 0.003


def test_the_heading_it_begins_with_is_taken_into_account() -> None:
    trial = Trial(LocalExploration(rows=1, columns=1), goal=ExploreLocally("rows", heading=0.1))
    trial.run(ticks=400)
    assert trial.behavior.succeeded
    assert trial.pose.heading == pytest.approx(-0.1, abs=0.01)


def test_places_behind_a_wall_are_given_up() -> None:
    """As if a wall stood ahead wherever it looks along the x axis: columns ahead cannot be reached."""
    trial = Trial(LocalExploration(rows=3, columns=3, compass=False, landmarks=False), goal=ExploreLocally())
    for _ in range(20_000):
        if trial.behavior.finished:
            break
        gap = 0.07 - trial.pose.x - 0.035
        toward = math.cos(trial.pose.heading)
        front = gap / toward if toward > 0.8 else math.inf
        trial.step(percept(front=max(front, 0.0)))
    samples = trial.behavior.result
    assert trial.behavior.succeeded
    assert samples.unreachable > 0
    assert samples.visited + samples.unreachable == 9
    assert samples.positions[:, 0].max() < 0.07 - 0.035


def explored(noise: str, seed: int) -> tuple[BehaviorFinished, Pose, int, float]:
    """At env1's first corner: how it ended, the true error at the end, collisions, the worst sample (m)."""
    world = open_world("env1", engine="kinematic", noise=noise, seed=seed, start=NODE)
    agent, heard = Agent(world.robots[0], [LocalExploration()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("local-exploration", ExploreLocally("rows", 0.0, WALLS, True))
    track = []
    for _ in range(20_000):
        agent.tick()
        world.step()
        seen = NODE.relative(world.true_pose())
        track.append((seen.x, seen.y))
        if not agent.is_active("local-exploration"):
            break
    finished = event_of(heard, BehaviorFinished)
    driven = np.array(track)
    off = [np.hypot(*(driven - place).T).min() for place in finished.result.positions]
    return finished, NODE.relative(world.true_pose()), world.collisions(), float(max(off))


@pytest.mark.slow
def test_in_a_corner_walls_keep_the_pose_good_enough_for_the_map() -> None:
    finished, error, collisions, worst = explored("thesis", seed=1)
    samples = finished.result
    assert finished.succeeded
    assert 8 <= samples.visited < 25
    assert samples.visited + samples.unreachable == 25
    assert math.hypot(error.x, error.y) < 0.012
    assert abs(error.heading) < math.radians(4.0)
    assert worst < 0.02
    assert collisions == 0


@settings(max_examples=40, deadline=None)
@given(percept_runs())
def test_whatever_is_sensed_its_proposals_are_valid(run: list[Percept]) -> None:
    trial = Trial(LocalExploration(), goal=ExploreLocally())
    for sensed in run:
        assert_valid(trial.step(sensed))


def test_it_looks_around_first() -> None:
    trial = Trial(LocalExploration(), goal=ExploreLocally())
    trial.step()
    assert trial.behavior.state is Exploring.VIEW


def test_only_an_explore_locally_goal_is_taken() -> None:
    with pytest.raises(GoalError, match="local-exploration needs an ExploreLocally goal, not 7"):
        Trial(LocalExploration(), goal=7)
