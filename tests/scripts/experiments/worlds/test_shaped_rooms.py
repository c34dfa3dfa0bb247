"""Rooms of other shapes: each one closed, passable, and the same again."""

from collections.abc import Callable

import pytest
from tolman.scripts.experiments.worlds.shaped_rooms import NARROW, SHAPES, shaped_room
from tolman.world.robot import EPUCK
from tolman.world.spec import Box, WorldSpec

Check = Callable[[WorldSpec], None]


@pytest.mark.parametrize("kind", SHAPES)
def test_a_room_of_another_shape_is_closed_and_the_same_again(
    kind: str, is_closed_around_both_starts: Check
) -> None:
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
