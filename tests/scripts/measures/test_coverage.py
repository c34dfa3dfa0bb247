"""Floor share, wall share and duplicates, in rooms where they can be told by hand."""

import math

import numpy as np
import pytest
from tolman.scripts.measures.coverage import coverage, duplicates, floor_share, wall_share
from tolman.scripts.measures.grid import Floor
from tolman.world.robot import Pose
from tolman.world.spec import Box, Wall, WorldSpec, room_walls

ROOM = WorldSpec("room", room_walls(1.0, 1.0))
START = Pose(0.5, 0.057, 0.0)


def along_the_walls(width: float = 1.0, depth: float = 1.0, aside: float = 0.057) -> np.ndarray:
    """A loop right round a rectangular room, a point a centimeter."""
    xs, ys = np.arange(aside, width - aside, 0.01), np.arange(aside, depth - aside, 0.01)
    return np.concatenate(
        [
            np.column_stack((xs, np.full(len(xs), aside))),
            np.column_stack((np.full(len(ys), width - aside), ys)),
            np.column_stack((xs, np.full(len(xs), depth - aside))),
            np.column_stack((np.full(len(ys), aside), ys)),
        ]
    )


def test_a_loop_along_all_walls_follows_all_of_them_but_not_all_the_floor() -> None:
    found = coverage(ROOM, START, {}, along_the_walls(), along_the_walls())
    assert found.wall_share > 0.99
    inner = (1.0 - 2 * (0.057 + 0.2)) ** 2 / (1.0 - 2 * 0.035) ** 2
    assert found.floor_share == pytest.approx(1.0 - inner, abs=0.03)


def test_half_of_the_loop_follows_half_of_the_walls() -> None:
    track = along_the_walls()
    half = track[: len(track) // 2]
    floor = Floor.of(ROOM)
    share = wall_share(ROOM, floor, floor.reachable(START.x, START.y), half)
    ends = 2 * 0.085 / 4.0  # of the walls beyond, which are as near
    assert share == pytest.approx(0.5 + ends, abs=0.01)


def test_the_other_side_of_a_thin_wall_is_not_followed() -> None:
    spec = WorldSpec("two", (*room_walls(1.0, 1.0), Wall((0.5, 0.0), (0.5, 0.8), 0.012)))
    floor = Floor.of(spec)
    reachable = floor.reachable(0.2, 0.5)
    left = np.column_stack((np.full(60, 0.494 - 0.057), np.linspace(0.1, 0.7, 60)))
    # Walls: 4 m outside, less two of 6 mm behind the thin wall, and 1.6 m of it; followed on one side, 0.6 m.
    assert wall_share(spec, floor, reachable, left) == pytest.approx(0.62 / 5.6, abs=0.03)


def test_what_cannot_be_reached_does_not_count() -> None:
    closed = WorldSpec("closed", (*room_walls(1.0, 1.0), Box(0.75, 0.5, 0.02, 1.0)))
    floor = Floor.of(closed)
    reachable = floor.reachable(0.2, 0.5)
    assert floor.places(reachable)[:, 0].max() < 0.74
    here = floor.places(reachable)
    assert floor_share(floor, reachable, here) == 1.0


def test_a_map_that_knows_nothing_covers_nothing() -> None:
    found = coverage(ROOM, START, {}, np.empty((0, 2)), np.empty((0, 2)))
    assert (found.floor_share, found.wall_share, found.duplicates) == (0.0, 0.0, 0)


def test_nodes_at_one_place_facing_one_wall_are_one_place() -> None:
    here, again, across = Pose(0.0, 0.0, 0.0), Pose(0.03, 0.0, 0.1), Pose(0.0, 0.0, math.pi)
    assert duplicates([here, again]) == 1
    assert duplicates([here, across]) == 0
    assert duplicates([here, Pose(0.06, 0.0, 0.0)]) == 0
