from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent.perception.wall_scan import SeenWall, WallScan
from tolman.world.robot import EPUCK, Percept, wrap_angle

Between = Callable[..., Percept]
directions = st.floats(-math.pi, math.pi)
distances = st.floats(0.045, 0.075)
STEP = 0.035
"""About what the robot turns in one tick (rad)."""


def scan(
    between: Between, walls: list[tuple[float, float]], turn: float = math.tau, start: float = 0.0
) -> list[SeenWall]:
    collected = WallScan(EPUCK)
    for tick in range(int(turn / STEP)):
        heading = start + tick * STEP
        collected.add(heading, between(walls, heading))
    return collected.walls()


def match(found: list[SeenWall], normal: float) -> SeenWall | None:
    near = [wall for wall in found if abs(wrap_angle(wall.normal - normal)) < 0.2]
    return near[0] if near else None


@settings(deadline=None, max_examples=40)
@given(directions, distances, directions)
def test_a_wall_at_any_angle_is_found_where_it_is(
    between: Between, normal: float, distance: float, start: float
) -> None:
    (wall,) = scan(between, [(normal, distance)], start=start)
    assert abs(wrap_angle(wall.normal - normal)) < math.radians(1.0)
    assert wall.distance == pytest.approx(distance, abs=1e-3)
    assert 0.0 < wall.deviation < math.radians(2.0)


@settings(deadline=None, max_examples=40)
@given(directions, distances, distances, st.sampled_from([90.0, 75.0, 105.0]))
def test_both_walls_of_a_corner_are_found(
    between: Between, normal: float, first: float, second: float, degrees: float
) -> None:
    other = normal + math.radians(degrees)
    found = scan(between, [(normal, first), (other, second)])
    for direction, distance in ((normal, first), (other, second)):
        wall = match(found, direction)
        if wall is None:  # its foot is hidden by the other wall or too near the corner
            continue
        assert abs(wrap_angle(wall.normal - direction)) < math.radians(2.0)
        assert wall.distance == pytest.approx(distance, abs=2e-3)
    assert match(found, normal if first < second else other) is not None


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, 133.0])
def test_at_a_node_in_a_square_corner_both_walls_are_found(between: Between, degrees: float) -> None:
    normal = math.radians(degrees)
    found = scan(between, [(normal, 0.057), (normal + 0.5 * math.pi, 0.057)])
    assert len(found) == 2
    for direction in (normal, normal + 0.5 * math.pi):
        wall = match(found, direction)
        assert wall is not None
        assert abs(wrap_angle(wall.normal - direction)) < math.radians(0.5)
        assert wall.distance == pytest.approx(0.057, abs=5e-4)


@pytest.mark.parametrize("degrees", [45.0, 60.0, 120.0, 135.0])
def test_walls_that_meet_at_a_slant_are_not_mistaken_for_others(between: Between, degrees: float) -> None:
    other = math.radians(degrees)
    for wall in scan(between, [(0.0, 0.05), (other, 0.05)]):
        off = min(abs(wrap_angle(wall.normal)), abs(wrap_angle(wall.normal - other)))
        assert off < math.radians(2.0)


def test_noise_leaves_a_wall_within_a_degree_or_so(between: Between) -> None:
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(20):
        collected = WallScan(EPUCK)
        for tick in range(180):
            seen = between([(0.7, 0.057)], tick * STEP)
            noisy = tuple(v * (1.0 + rng.normal(0.0, 0.03)) for v in seen.infrared)
            collected.add(tick * STEP, Percept(0, 0.0, noisy, (0.0, 0.0)))
        (wall,) = collected.walls()
        errors.append(abs(wall.normal - 0.7))
    assert float(np.mean(errors)) < math.radians(0.6)
    assert max(errors) < math.radians(1.5)


def test_nothing_is_found_in_the_open_or_beyond_reach_or_in_too_short_a_look(between: Between) -> None:
    assert scan(between, []) == []
    assert scan(between, [(0.0, EPUCK.body_radius + 0.06)]) == []
    assert scan(between, [(0.0, 0.05)], turn=9 * STEP) == []


def test_a_wall_whose_foot_was_not_swept_over_is_not_told(between: Between) -> None:
    found = scan(between, [(math.radians(200.0), 0.045)], turn=math.radians(25.0), start=math.radians(95.0))
    assert all(abs(wrap_angle(wall.normal - math.radians(200.0))) < math.radians(3.0) for wall in found)
