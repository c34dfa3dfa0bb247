from __future__ import annotations

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from numpy.typing import NDArray
from tolman.maps.errors import MapError, NoPathError, UnknownNodeError
from tolman.maps.local.config import DEFAULT, THESIS_1, THESIS_2, LocalMapConfig
from tolman.maps.local.local_map import LocalMap
from tolman.maps.local.training import tie_positions


def lattice_walk(step: float = 0.02) -> NDArray[np.float64]:
    """Positions every 2 cm along five rows 5 cm apart: what local exploration samples in the open."""
    rows = []
    for index, y in enumerate(np.arange(-0.1, 0.101, 0.05)):
        xs = np.arange(-0.1, 0.101, step)
        rows += [(x, y) for x in (xs if index % 2 == 0 else xs[::-1])]
    return np.array(rows)


def panorama_at(x: float, y: float) -> NDArray[np.float64]:
    """Four views of a box with a pattern on its walls, smooth in the position."""
    rows, cols = np.mgrid[0:16, 0:16] / 16.0
    views = [np.sin(8 * cols + 3 * x * (k + 1)) * np.cos(5 * rows + 3 * y * (4 - k)) for k in range(4)]
    return np.clip(0.5 + 0.4 * np.array(views), 0.0, 1.0)


def built(config: LocalMapConfig = DEFAULT, seed: int = 0) -> LocalMap:
    places = lattice_walk()
    spots = places[::2]
    views = np.array([panorama_at(x, y) for x, y in spots])
    return LocalMap.build(places, spots, views, config, np.random.default_rng(seed), entry_heading=0.5)


@pytest.mark.parametrize("config", [DEFAULT, THESIS_1, THESIS_2])
def test_units_lie_in_the_space_that_was_sampled(config: LocalMapConfig) -> None:
    local = built(config)
    hit = local.metric.weights[local.hits > 0]
    assert (np.abs(hit) <= 0.1 + 1e-6).all()
    assert local.metric.units == 25
    assert local.entry_heading == 0.5
    assert local.hits.sum() == len(lattice_walk())


def test_a_view_is_located_near_where_it_was_taken() -> None:
    local = built()
    spots = np.random.default_rng(3).uniform(-0.09, 0.09, (40, 2))
    errors = [np.linalg.norm(local.locate(panorama_at(x, y)).position - (x, y)) for x, y in spots]
    assert np.mean(errors) < 0.03
    assert local.locate(panorama_at(*lattice_walk()[0])).confidence > 0.5


def test_a_view_from_elsewhere_has_little_confidence() -> None:
    assert built().locate(np.random.default_rng(0).uniform(0.0, 1.0, (4, 16, 16))).confidence < 0.3


def test_positions_are_tied_by_running_midpoints_or_by_means() -> None:
    places = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 4.0], [9.0, 9.0]])
    winners = [1, 1, 1, 0]
    assert tie_positions(winners, places, 3, "midpoint")[1].tolist() == [2.5, 2.0]  # eq. 3.32
    mean = tie_positions(winners, places, 3, "mean")
    assert mean[1] == pytest.approx([2.0, 4.0 / 3.0])
    assert mean[0].tolist() == [9.0, 9.0]
    assert np.isnan(mean[2]).all()


def test_paths_go_along_kept_edges_and_around_blocked_ones() -> None:
    local = built()
    start, goal = local.nearest_unit(-0.1, -0.1), local.nearest_unit(0.1, 0.1)
    path = local.path(start, goal)
    kept = {(int(i), int(j)) for i, j in local.edges}
    assert path[0] == start
    assert path[-1] == goal
    assert all((min(a, b), max(a, b)) in kept for a, b in pairwise(path))
    local.block(path[1], path[0])
    around = local.path(start, goal)
    assert around[:2] != path[:2]
    assert (min(path[:2]), max(path[:2])) in local.blocked
    local.unblock(path[0], path[1])
    assert local.path(start, goal) == path


def test_a_unit_cut_off_cannot_be_reached() -> None:
    local = built()
    goal = local.nearest_unit(0.1, 0.1)
    for i, j in local.edges.tolist():
        if goal in (i, j):
            local.block(i, j)
    with pytest.raises(NoPathError, match="cannot be reached"):
        local.path(local.nearest_unit(), goal)


def test_free_space_is_a_graph_of_hit_units() -> None:
    local = built()
    graph = local.free_space()
    assert set(graph) == set(np.flatnonzero(local.hits > 0).tolist())
    assert all(data["distance"] > 0.0 and data["blocked"] is False for _, _, data in graph.edges(data=True))


def test_the_nearest_unit_is_one_that_was_visited() -> None:
    local = LocalMap.build([[0.0, 0.0], [0.1, 0.0]])
    assert local.hits[local.nearest_unit()] > 0
    assert local.position(local.nearest_unit(0.1, 0.0)) == pytest.approx((0.1, 0.0), abs=0.02)


def test_without_panoramas_there_is_no_locating() -> None:
    local = LocalMap.build(lattice_walk())
    assert local.perceptual is None
    with pytest.raises(MapError, match="no perceptual SOM"):
        local.locate(panorama_at(0.0, 0.0))


def test_unknown_units_and_edges_are_named() -> None:
    local = built()
    with pytest.raises(UnknownNodeError, match="no metric unit 99"):
        local.path(0, 99)
    with pytest.raises(UnknownNodeError, match="no free-space edge"):
        local.block(0, 24)


@pytest.mark.parametrize(
    ("positions", "spots", "views"),
    [
        ([], None, None),
        ([[np.nan, 0.0]], None, None),
        ([[0.0, 0.0, 0.0]], None, None),
        ([[0.0, 0.0]], [[0.0, 0.0], [0.1, 0.0]], np.zeros((1, 4, 16, 16))),
    ],
)
def test_samples_that_do_not_fit_are_refused(positions: object, spots: object, views: object) -> None:
    with pytest.raises(MapError):
        LocalMap.build(positions, spots, views)  # type: ignore[arg-type]


def walk_around_a_wall(rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions in order, a body away from a wall without thickness; the wall's ends (2, 2) m."""
    angle = rng.uniform(0.0, np.pi)
    start = rng.uniform(-0.05, 0.05, 2)
    wall = np.array([start, start + 0.4 * np.array([np.cos(angle), np.sin(angle)])])
    places = lattice_walk() + rng.normal(0.0, 0.003, (len(lattice_walk()), 2))
    along = wall[1] - wall[0]
    share = np.clip((places - wall[0]) @ along / (along @ along), 0.0, 1.0)
    return places[np.linalg.norm(places - wall[0] - share[:, None] * along, axis=1) > 0.037], wall


def crosses(a: NDArray[np.float64], b: NDArray[np.float64], wall: NDArray[np.float64]) -> bool:
    def side(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    apart = side(*wall, a) * side(*wall, b)  # type: ignore[call-arg]
    return apart < 0.0 and side(a, b, wall[0]) * side(a, b, wall[1]) < 0.0


def test_next_to_no_kept_edge_crosses_a_wall_without_thickness() -> None:
    crossing = edges = 0
    for seed in range(30):
        places, wall = walk_around_a_wall(np.random.default_rng(seed))
        local = LocalMap.build(places)
        units = local.metric.weights
        edges += len(local.edges)
        crossing += sum(crosses(units[i], units[j], wall) for i, j in local.edges.tolist())
    assert edges > 500
    assert crossing <= 0.01 * edges


def test_no_unit_that_was_hit_lies_between_the_two_sides_of_a_wall() -> None:
    side = np.column_stack((np.arange(-0.08, 0.09, 0.02), np.full(9, 0.04)))
    places = np.vstack((side, side[::-1] * (1.0, -1.0)))  # along y = 0.04 and back along -0.04: a wall at 0
    for rows, cols in ((1, 3), (2, 2), (3, 1)):
        local = LocalMap.build(places, config=LocalMapConfig(rows=rows, cols=cols))
        hit = local.metric.weights[local.hits > 0]
        away = np.linalg.norm(hit[:, None] - places, axis=2).min(axis=1)
        assert (away <= 0.03 + 1e-9).all()
        assert (np.abs(hit[:, 1]) > 0.01).all()
        assert local.hits.sum() == len(places)


def test_free_space_joins_units_that_were_hit_alone() -> None:
    for seed in range(10):
        places, _ = walk_around_a_wall(np.random.default_rng(seed))
        local = LocalMap.build(places)
        assert (local.hits[local.edges] > 0).all()


def test_parts_between_which_no_wall_fits_are_joined_wherever_samples_left_off() -> None:
    arms = [
        np.column_stack((np.arange(0.02, 0.1, 0.02), np.zeros(4))) @ turn
        for turn in (np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]]), -np.eye(2))
    ]
    local = LocalMap.build(np.vstack(([[0.0, 0.0]], *arms)))  # three dead ends, driven back without sampling
    graph = local.free_space()
    assert nx.is_connected(graph)
    assert set(graph) == set(np.flatnonzero(local.hits > 0).tolist())


def obstacle_free(place: NDArray[np.float64], center: NDArray[np.float64], radius: float) -> bool:
    return bool(np.linalg.norm(place - center) > radius)


@pytest.mark.parametrize("seed", range(30))
def test_no_visited_unit_lies_in_a_round_obstacle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    center, radius = rng.uniform(-0.06, 0.06, 2), 0.035  # the robot's center stays a body radius away from it
    reach = radius + 0.035
    places = lattice_walk() + rng.normal(0.0, 0.004, (len(lattice_walk()), 2))
    places = places[np.linalg.norm(places - center, axis=1) > reach]
    local = LocalMap.build(places)
    hit = local.metric.weights[local.hits > 0]
    assert (np.linalg.norm(hit - center, axis=1) > radius).all()
