"""Rooms drawn from seeds: each one closed, passable, and the same again."""

import numpy as np
import pytest
from tolman.scripts.experiments.runs.random_rooms import KINDS, random_room
from tolman.scripts.experiments.runs.shaped_rooms import NARROW, SHAPES, shaped_room
from tolman.world.geometry import Plan, cast
from tolman.world.robot import EPUCK
from tolman.world.spec import Box, WorldSpec

SEEDS = range(30)


def is_closed_around_both_starts(spec: WorldSpec) -> None:
    plan = Plan(spec.shapes)
    turns = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False) + 0.013
    directions = np.stack((np.cos(turns), np.sin(turns)), 1)
    for side in ("right", "left"):
        pose = spec.start(side)
        assert plan.clearance(pose.x, pose.y) > EPUCK.body_radius
        origins = np.broadcast_to(np.array((pose.x, pose.y)), directions.shape)
        assert np.isfinite(cast(origins, directions, plan.segments)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drawn_room_is_closed_around_both_starts(seed: int) -> None:
    is_closed_around_both_starts(random_room(seed))


@pytest.mark.parametrize("kind", SHAPES)
def test_a_room_of_another_shape_is_closed_and_the_same_again(kind: str) -> None:
    for seed in range(12):
        spec = shaped_room(kind, seed)
        is_closed_around_both_starts(spec)
        assert shaped_room(kind, seed).digest == spec.digest
    assert len({shaped_room(kind, seed).digest for seed in range(12)}) == 12


@pytest.mark.parametrize("seed", range(12))
def test_a_narrow_room_has_a_passage_hardly_wider_than_the_robot(seed: int) -> None:
    *walls, block, _ = shaped_room("narrow", seed).shapes
    assert isinstance(block, Box)
    depth = max(wall.y - 0.5 * wall.depth for wall in walls if isinstance(wall, Box))
    assert NARROW[0] <= depth - (block.y + 0.5 * block.depth) <= NARROW[1]
    assert NARROW[0] > 2.0 * EPUCK.body_radius


def test_seeds_draw_different_rooms_and_the_same_ones_again() -> None:
    digests = [random_room(seed).digest for seed in SEEDS]
    assert len(set(digests)) == len(digests)
    assert [random_room(seed).digest for seed in SEEDS] == digests


def test_all_kinds_of_rooms_are_drawn_in_turn() -> None:
    assert ["maze" in random_room(seed).name for seed in range(len(KINDS))] == ["maze" in k for k in KINDS]
