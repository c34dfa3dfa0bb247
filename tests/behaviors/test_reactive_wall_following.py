"""The published wall follower: equations 3.9 to 3.14, algorithm 5, and that it touches nothing on its way."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent import Agent
from tolman.agent.goals import Follow
from tolman.behaviors.reactive_wall_following import ReactiveWallFollowing
from tolman.world import open_world
from tolman.world.robot import Percept, WheelCommand

raw = st.floats(0.0, 4095.0)
percepts = st.lists(raw, min_size=8, max_size=8).map(tuple)


class _Still:
    """Stands where the follower looks for a context: it asks it for nothing."""


def command(side: str, infrared: tuple[float, ...]) -> WheelCommand:
    follower = ReactiveWallFollowing()
    follower.start(Follow(side), _Still())  # type: ignore[arg-type]
    proposal = follower.propose(Percept(0, 0.0, infrared, (0.0, 0.0)), _Still())  # type: ignore[arg-type]
    assert proposal is not None
    return proposal.command


@given(percepts)
def test_the_left_side_is_the_exact_mirror_image_of_the_right(infrared: tuple[float, ...]) -> None:
    right, left = command("right", infrared), command("left", infrared[::-1])
    assert (left.left, left.right) == (right.right, right.left)


def test_with_nothing_near_it_circles_toward_the_walls_side() -> None:
    assert command("right", (0.0,) * 8) == WheelCommand(233.0, 116.5)
    assert command("left", (0.0,) * 8) == WheelCommand(116.5, 233.0)


def test_a_wall_ahead_turns_it_away_from_the_followed_side() -> None:
    ahead = (800.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 800.0)
    # Eq. 3.12 by hand: 10 * 800 / 16 for each of the two front sensors.
    assert command("right", ahead) == WheelCommand(233.0 - 1000.0, 233.0 + 1000.0)
    assert command("left", ahead) == WheelCommand(233.0 + 1000.0, 233.0 - 1000.0)


def test_a_near_wall_at_the_side_attracts_until_it_is_too_near() -> None:
    far = command("right", (0.0, 120.0, 400.0, 100.0, 0.0, 0.0, 0.0, 0.0))
    near = command("right", (0.0, 300.0, 900.0, 100.0, 0.0, 0.0, 0.0, 0.0))
    assert far.left > far.right  # toward the wall on the right
    assert near.left < near.right


def test_it_refuses_a_goal_that_is_no_follow() -> None:
    with pytest.raises(TypeError, match="needs a Follow goal"):
        ReactiveWallFollowing().start("right", _Still())  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("side", ["right", "left"])
def test_it_goes_round_env1_two_centimeters_from_the_wall_and_touches_nothing(side: str) -> None:
    world = open_world("env1", seed=5, engine="kinematic", start=side)
    agent = Agent(world.robots[0], [ReactiveWallFollowing()])
    agent.start("reactive-wall-following", Follow(side))
    start = world.true_pose()
    distances, back = [], False
    for _ in range(round(170.0 / 0.032)):
        agent.tick()
        world.step()
        pose = world.true_pose()
        distances.append(world.clearance(pose.x, pose.y) - world.robots[0].geometry.body_radius)
        back = back or (agent.odometry.travelled > 3.0 and pose.distance_to(start) < 0.05)
    assert world.collisions() == 0
    assert 0.015 < float(np.median(distances)) < 0.025
    assert back
    assert math.isfinite(agent.odometry.heading)
