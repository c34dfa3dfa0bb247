"""Rooms drawn from seeds: each one closed, passable, and the same again."""

from collections.abc import Callable

import pytest
from tolman.scripts.experiments.worlds.random_rooms import KINDS, random_room
from tolman.world.spec import WorldSpec

Check = Callable[[WorldSpec], None]
SEEDS = range(30)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drawn_room_is_closed_around_both_starts(seed: int, is_closed_around_both_starts: Check) -> None:
    is_closed_around_both_starts(random_room(seed))


def test_seeds_draw_different_rooms_and_the_same_ones_again() -> None:
    digests = [random_room(seed).digest for seed in SEEDS]
    assert len(set(digests)) == len(digests)
    assert [random_room(seed).digest for seed in SEEDS] == digests


def test_all_kinds_of_rooms_are_drawn_in_turn() -> None:
    assert ["maze" in random_room(seed).name for seed in range(len(KINDS))] == ["maze" in k for k in KINDS]
