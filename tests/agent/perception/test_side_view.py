from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.perception.side_view import SideView, WallFilter
from tolman.plugins.testing import percept
from tolman.world.robot import EPUCK, Percept

Between = Callable[..., Percept]
QUARTER = 0.5 * math.pi
sides = st.sampled_from(["right", "left"])


def beside(between: Between, side: str, distance: float, away: float) -> SideView:
    """A wall on that side; the heading points away from it by `away` (rad)."""
    sign = 1.0 if side == "right" else -1.0
    view = SideView(EPUCK, side)
    view.read(between([(-sign * (0.5 * math.pi + away), distance)]))
    return view


@given(sides, st.floats(0.042, 0.075), st.floats(-0.35, 0.35))
def test_the_side_wall_s_distance_and_angle_are_recovered_on_either_side(
    between: Between, side: str, distance: float, away: float
) -> None:
    wall = beside(between, side, distance, away).side_wall()
    if wall is None:  # one of the two sensors cannot see so far
        assert distance / math.cos(abs(away) + 0.78) > EPUCK.body_radius + EPUCK.infrared_range - 1e-3
        return
    assert wall[0] == pytest.approx(distance, abs=1e-3)
    assert wall[1] == pytest.approx(away, abs=0.02)


def test_the_published_following_distance_is_seen_by_both_sensors(between: Between) -> None:
    assert beside(between, "right", 0.057, 0.0).side_wall() == pytest.approx((0.057, 0.0), abs=1e-3)


@given(sides, st.floats(0.04, 0.06), st.floats(-0.2, 0.2))
def test_the_front_wall_tells_how_far_to_turn_to_be_parallel(
    between: Between, side: str, distance: float, tilt: float
) -> None:
    sign = 1.0 if side == "right" else -1.0
    view = SideView(EPUCK, side)
    view.read(between([(sign * tilt, distance)]))
    front = view.front_wall()
    assert front is not None
    assert front[0] == pytest.approx(distance, abs=2e-3)
    assert front[1] == pytest.approx(0.5 * math.pi + tilt, abs=0.06)


def test_a_front_wall_seen_by_one_sensor_counts_as_standing_across() -> None:
    values = [0.0] * 8
    values[0] = 400.0
    for side in ("right", "left"):
        view = SideView(EPUCK, side)
        view.read(Percept(0, 0.0, tuple(values), (0.0, 0.0)))
        front = view.front_wall()
        assert front is not None
        assert front[1] == pytest.approx(0.5 * math.pi)


def test_in_the_open_there_is_no_wall() -> None:
    view = SideView(EPUCK, "left")
    view.read(percept())
    assert view.side_wall() is None
    assert view.front_wall() is None


@given(st.floats(0.0, 0.06), st.floats(0.0, 0.06))
def test_left_and_right_are_mirror_images(near: float, ahead: float) -> None:
    right, left = SideView(EPUCK, "right"), SideView(EPUCK, "left")
    right.read(percept(right=near, front=ahead))
    left.read(percept(left=near, front=ahead))
    assert (right.near, right.far, right.diagonal, right.side, right.rear) == pytest.approx(
        (left.near, left.far, left.diagonal, left.side, left.rear)
    )
    assert right.sign == -left.sign


@given(st.floats(0.04, 0.07), st.floats(-0.2, 0.2), st.lists(st.floats(-0.02, 0.02), max_size=30))
def test_without_noise_prediction_alone_keeps_track(
    distance: float, angle: float, turns: list[float]
) -> None:
    wall = WallFilter(distance, angle)
    true_distance, true_angle = distance, angle
    for turn in turns:
        wall.predict(0.001, turn)
        true_distance += 0.001 * math.sin(true_angle + 0.5 * turn)
        true_angle += turn
    assert wall.distance == pytest.approx(true_distance, abs=1e-9)
    assert wall.angle == pytest.approx(true_angle, abs=1e-9)


@given(st.floats(-0.004, 0.004), st.floats(-0.08, 0.08))
def test_measured_lines_draw_it_to_the_wall(off: float, tilt: float) -> None:
    wall = WallFilter(0.057 + off, tilt)
    spread = wall.angle_deviation
    for _ in range(50):
        assert wall.correct((0.057, 0.0))
    assert wall.distance == pytest.approx(0.057, abs=2e-4)
    assert wall.angle == pytest.approx(0.0, abs=3e-3)
    assert wall.angle_deviation < 0.1 * spread
    assert wall.samples == 50


def test_the_errors_of_a_drive_are_as_large_as_the_filter_says() -> None:
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(300):
        true_distance, true_angle = 0.057, rng.normal(0.0, 0.03)
        wall = WallFilter(0.057 + rng.normal(0.0, 0.003), 0.0, 0.05)
        for _ in range(60):
            slip = rng.normal(0.0, wall.turn_noise)
            wall.predict(0.00096, slip - 0.05 * wall.angle)
            true_distance += 0.00096 * math.sin(true_angle)
            true_angle -= 0.05 * wall.angle
            wall.correct(
                (
                    true_distance + rng.normal(0.0, wall.distance_noise),
                    true_angle + rng.normal(0.0, wall.angle_noise),
                )
            )
        ratios.append(((wall.angle - true_angle) / wall.angle_deviation) ** 2)
    assert 0.5 < float(np.mean(ratios)) < 1.6


@pytest.mark.parametrize("line", [(0.12, 0.0), (0.057, 0.9), (0.012, 0.0), (0.057, -0.9)])
def test_a_line_that_cannot_be_this_wall_is_refused(line: tuple[float, float]) -> None:
    wall = WallFilter(0.057)
    assert not wall.correct(line)
    assert (wall.distance, wall.angle, wall.samples) == (0.057, 0.0, 0)


def test_a_line_that_recedes_is_refused_sooner_than_one_that_comes_near() -> None:
    near, far = WallFilter(0.057), WallFilter(0.057)
    assert near.correct((0.057 - 0.03, 0.0))
    assert not far.correct((0.057 + 0.03, 0.0))


def test_a_distance_alone_corrects_the_distance_and_a_wild_one_nothing() -> None:
    wall = WallFilter(0.050)
    for _ in range(20):
        wall.correct_distance(0.057)
    assert wall.distance == pytest.approx(0.057, abs=3e-4)
    wall.correct_distance(0.2)
    assert wall.distance == pytest.approx(0.057, abs=3e-4)


@pytest.mark.parametrize("degrees", [25.0, 35.0, 45.0])
def test_a_slanted_wall_ahead_is_seen_by_one_front_sensor_and_the_diagonal_one(
    between: Callable[..., Percept], degrees: float
) -> None:
    turn = math.radians(degrees)
    view = SideView(EPUCK, "right")
    view.read(between([(-QUARTER, 0.057), (turn - QUARTER, 0.060)]))
    seen = view.slanted_wall(0.057, 0.0)
    assert seen is not None
    assert seen == pytest.approx((0.060, turn), abs=0.004)


def test_beside_a_straight_wall_or_across_one_there_is_no_slanted_wall(
    between: Callable[..., Percept],
) -> None:
    view = SideView(EPUCK, "right")
    for walls in ([(-QUARTER, 0.057)], [(-QUARTER, 0.057), (0.0, 0.070)]):
        view.read(between(walls))
        assert view.slanted_wall(0.057, 0.0) is None
