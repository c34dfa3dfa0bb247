from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from tolman.world.formats.contours import Mask, outlines, straightened, walls_along
from tolman.world.formats.rosmap import smoothed
from tolman.world.geometry import point_segment_distances, signed_area

masks = hnp.arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12)))


@given(masks)
def test_outlines_go_round_every_cell_once_with_the_area_on_the_left(area: Mask) -> None:
    loops = outlines(area)
    assert sum(signed_area([(x, y) for x, y in loop]) for loop in loops) == pytest.approx(area.sum())
    steps = [(tuple(a), tuple(b)) for loop in loops for a, b in zip(loop, np.roll(loop, -1, axis=0))]  # noqa: B905
    assert len(set(steps)) == len(steps)
    assert all(math.dist(a, b) == 1.0 for a, b in steps)


def test_cells_that_touch_at_a_corner_have_outlines_of_their_own() -> None:
    assert len(outlines(np.array([[True, False], [False, True]]))) == 2


@given(masks, st.floats(1.0, 2.0))
def test_straight_edges_keep_near_the_cells_they_were_drawn_with(area: Mask, tolerance: float) -> None:
    for loop in outlines(area):
        points = straightened(loop, tolerance)
        assert len(points) >= 3
        edges = np.array([(*a, *b) for a, b in zip(points, (*points[1:], points[0]), strict=True)])
        for x, y in loop:
            assert point_segment_distances(x, y, edges).min() <= 2.5 * tolerance


def test_the_smallest_things_keep_their_shape() -> None:
    area = np.ones((20, 20), dtype=bool)
    area[4, 4] = area[9:11, 9] = area[14:16, 14:16] = False
    holes = [straightened(loop, 2.0) for loop in outlines(area)]
    assert sorted(round(signed_area(points), 9) for points in holes)[:3] == [-4.0, -2.0, -1.0]


def turned_room(degrees: float, size: int = 90) -> Mask:
    """A square room of 60 cells, turned, drawn cell by cell."""
    ups, alongs = np.mgrid[:size, :size] - (size - 1) / 2
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    room: Mask = (np.abs(cosine * alongs + sine * ups) < 30) & (np.abs(cosine * ups - sine * alongs) < 30)
    return room


@given(st.floats(0.0, 90.0), st.integers(0, 99))
def test_a_ragged_room_at_any_angle_has_four_straight_walls(degrees: float, seed: int) -> None:
    room = turned_room(degrees)
    rng = np.random.default_rng(seed)
    edge = room & ~(np.roll(room, 1, 0) & np.roll(room, -1, 0) & np.roll(room, 1, 1) & np.roll(room, -1, 1))
    room &= ~(edge & (rng.random(room.shape) < 0.2))
    (loop,) = outlines(smoothed(room, 0.01))
    points = straightened(loop, 2.0)
    assert len(points) <= 7  # a corner may be cut off
    edges = [(x1 - x0, y1 - y0) for (x0, y0), (x1, y1) in zip(points, (*points[1:], points[0]), strict=True)]
    walls = [edge for edge in edges if math.hypot(*edge) > 40.0]
    assert len(walls) == 4
    for along, up in walls:
        off = math.remainder(math.atan2(up, along) - math.radians(degrees), 0.5 * math.pi)
        assert abs(off) < math.radians(2.5)


def test_what_lies_along_the_cells_stays_exactly_where_it_is() -> None:
    area = np.zeros((40, 60), dtype=bool)
    area[5:35, 5:55] = True
    area[5:20, 30:34] = False
    (loop,) = outlines(area)
    corners = {(5, 5), (30, 5), (30, 20), (34, 20), (34, 5), (55, 5), (55, 35), (5, 35)}
    assert {(round(x, 9), round(y, 9)) for x, y in straightened(loop, 2.0)} == corners


def test_thin_walls_stay_and_dents_and_bumps_go() -> None:
    area = np.zeros((60, 60), dtype=bool)
    area[5:55, 5:55] = True
    area[5:40, 30] = False  # a wall of one cell that reaches into the room
    area[3:5, 10:12] = True  # a dent
    area[53:55, 20:22] = False  # a bump
    area[30:32, 45:47] = False  # a thin pillar
    smooth = smoothed(area, 0.01)
    assert not smooth[3].any()
    assert smooth[53:55, 20:22].all()
    assert not smooth[5:40, 30].any()
    assert not smooth[30:32, 45:47].any()


def test_walls_lie_beside_an_outline_and_close_at_its_corners() -> None:
    room = [
        (0.0, 0.0),
        (40.0, 0.0),
        (40.0, 30.0),
        (20.0, 30.0),
        (20.0, 28.0),
        (19.0, 28.0),
        (19.0, 30.0),
        (0.0, 30.0),
    ]
    quads = walls_along(room, 1.0)
    assert len(quads) == len(room)
    for quad, after in zip(quads, (*quads[1:], quads[0]), strict=True):
        assert quad[3] == after[0]
        assert quad[2] == after[1]
        assert signed_area(quad) > 0.0
        for x, y in quad[1:3]:
            inside = 0.0 < x < 40.0 and 0.0 < y < 30.0
            assert not inside or (19.0 <= x <= 20.0 and y > 28.0)
