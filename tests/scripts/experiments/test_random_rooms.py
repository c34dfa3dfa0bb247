"""Rooms drawn from seeds: each one closed, passable, and the same again."""

import numpy as np
import pytest
from tolman.scripts.experiments.random_rooms import KINDS, random_room
from tolman.world.geometry import Plan, cast
from tolman.world.robot import EPUCK

SEEDS = range(30)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drawn_room_is_closed_around_both_starts(seed: int) -> None:
    spec = random_room(seed)
    plan = Plan(spec.shapes)
    turns = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False) + 0.013
    directions = np.stack((np.cos(turns), np.sin(turns)), 1)
    for side in ("right", "left"):
        pose = spec.start(side)
        assert plan.clearance(pose.x, pose.y) > EPUCK.body_radius
        origins = np.broadcast_to(np.array((pose.x, pose.y)), directions.shape)
        assert np.isfinite(cast(origins, directions, plan.segments)).all()


def test_seeds_draw_different_rooms_and_the_same_ones_again() -> None:
    digests = [random_room(seed).digest for seed in SEEDS]
    assert len(set(digests)) == len(digests)
    assert [random_room(seed).digest for seed in SEEDS] == digests


def test_all_kinds_of_rooms_are_drawn_in_turn() -> None:
    assert ["maze" in random_room(seed).name for seed in range(len(KINDS))] == ["maze" in k for k in KINDS]
