"""Shortest ways on the floor, against what geometry says."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.scripts.measures.grid import Floor, shortest
from tolman.scripts.measures.trips import shortest_way, spl
from tolman.world.robot import EPUCK
from tolman.world.spec import Box, WorldSpec, room_walls

ROOM = WorldSpec("room", room_walls(1.5, 1.5))
FLOOR = Floor.of(ROOM)
INSIDE = st.floats(0.06, 1.44)


@settings(max_examples=30)
@given(INSIDE, INSIDE, INSIDE, INSIDE)
def test_in_an_empty_room_the_shortest_way_is_straight(ax: float, ay: float, bx: float, by: float) -> None:
    way = shortest(FLOOR, (ax, ay), (bx, by))
    assert way is not None
    assert way == pytest.approx(math.dist((ax, ay), (bx, by)), rel=0.01, abs=0.015)


def test_around_a_block_the_way_touches_its_corners() -> None:
    spec = WorldSpec("block", (*room_walls(1.5, 1.5), Box(0.75, 0.5, 0.1, 1.0)))
    way = shortest_way(spec, (0.4, 0.5), (1.1, 0.5))
    assert way is not None
    radius = EPUCK.body_radius + 0.01
    height, aside = 0.5, 0.3  # up to the block's upper corners, from beside it
    tangent = math.sqrt(height**2 + aside**2 - radius**2)
    arc = radius * (math.atan2(height, aside) + math.asin(radius / math.hypot(height, aside)))
    assert way == pytest.approx(2 * (tangent + arc) + 0.1, rel=0.02)


def test_where_there_is_no_way_none_is_told() -> None:
    spec = WorldSpec("shut", (*room_walls(1.5, 1.5), Box(0.75, 0.75, 0.02, 1.5)))
    assert shortest_way(spec, (0.4, 0.5), (1.1, 0.5)) is None


def test_a_gap_is_passed_only_by_what_fits_through() -> None:
    for gap, passes in ((0.10, True), (0.07, False)):
        blocks = (
            Box(0.75, 0.75 - 0.5 * (gap + 0.8), 0.02, 0.8),
            Box(0.75, 0.75 + 0.5 * (gap + 0.8), 0.02, 0.8),
        )
        spec = WorldSpec("gap", (*room_walls(1.5, 1.5), *blocks))
        assert (shortest_way(spec, (0.4, 0.75), (1.1, 0.75)) is not None) == passes


def test_the_weighted_success_of_trips() -> None:
    assert spl(True, 2.0, 2.5) == pytest.approx(0.8)
    assert spl(True, 2.0, 1.9) == 1.0
    assert spl(False, 2.0, 2.0) == 0.0
    assert spl(True, None, 2.0) == 0.0
    assert spl(True, 0.0, 0.0) == 1.0
