from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tolman.agent.motion import drive_command, is_free, obstacles, shy_turn, spin_command
from tolman.plugins.testing import percept
from tolman.world.robot import CONTROL_PERIOD, EPUCK

angles = st.floats(-math.pi, math.pi)
speeds = st.floats(1.0, 1000.0)


@given(angles, speeds)
def test_a_spin_stays_in_place_within_its_limit_and_never_turns_too_far(angle: float, limit: float) -> None:
    command = spin_command(EPUCK, angle, limit)
    assert command.left == -command.right
    assert abs(command.right) <= limit
    turn = 2.0 * command.right * CONTROL_PERIOD * EPUCK.radians_per_step
    assert abs(turn) <= abs(angle) + 1e-9
    assert turn * angle >= 0.0


@given(angles)
def test_a_spin_without_a_limit_ends_the_turn_in_one_tick(angle: float) -> None:
    command = spin_command(EPUCK, angle, math.inf)
    assert 2.0 * command.right * CONTROL_PERIOD * EPUCK.radians_per_step == pytest.approx(angle, abs=1e-9)


@given(st.floats(-500.0, 500.0), st.floats(-10.0, 10.0))
def test_driving_keeps_its_speed_and_its_direction_however_sharp_the_turn(speed: float, rate: float) -> None:
    command = drive_command(EPUCK, speed, rate)
    assert 0.5 * (command.left + command.right) == pytest.approx(speed, abs=1e-9)
    assert command.left * speed >= 0.0
    assert command.right * speed >= 0.0
    assert (command.right - command.left) * rate >= 0.0


def test_a_gentle_turn_rate_is_met() -> None:
    command = drive_command(EPUCK, 233.0, 0.2)
    assert (command.right - command.left) * EPUCK.radians_per_step == pytest.approx(0.2)


def test_what_the_sensors_hit_lies_on_the_wall() -> None:
    points = obstacles(percept(right=0.02), EPUCK)
    assert len(points) >= 2
    for _, y in points:
        assert y == pytest.approx(-(EPUCK.body_radius + 0.02), abs=1e-6)


def test_an_empty_plain_has_no_obstacles() -> None:
    assert obstacles(percept(), EPUCK) == []


def test_a_wall_ahead_bars_the_way_from_where_the_shell_would_come_too_near() -> None:
    points = obstacles(percept(front=0.03), EPUCK)
    assert is_free(points, EPUCK, 0.02, 0.0)
    assert not is_free(points, EPUCK, 0.04, 0.0)
    assert not is_free(points, EPUCK, 0.02, 0.02)
    assert is_free(points, EPUCK, -0.05, 0.02)


points = st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), max_size=8)


@given(points, st.floats(-0.1, 0.1), st.floats(0.0, 0.03))
def test_a_free_way_is_free_for_less_margin_and_for_less_way(
    where: list[tuple[float, float]], way: float, margin: float
) -> None:
    assume(is_free(where, EPUCK, way, margin))
    assert is_free(where, EPUCK, way, 0.5 * margin)
    assert is_free(where, EPUCK, 0.5 * way, margin)


@given(points, st.floats(0.001, 0.1))
def test_backwards_is_forwards_turned_around(where: list[tuple[float, float]], way: float) -> None:
    turned = [(-x, -y) for x, y in where]
    assert is_free(where, EPUCK, way, 0.01) == is_free(turned, EPUCK, -way, 0.01)


def test_beside_a_wall_it_all_but_touches_it_turns_away_and_the_more_the_nearer() -> None:
    def beside(gap: float, side: float) -> float:
        return shy_turn([(0.0, side * (EPUCK.body_radius + gap))], EPUCK)

    assert beside(0.001, -1.0) > beside(0.003, -1.0) > 0.0
    assert beside(0.001, 1.0) == -beside(0.001, -1.0)
    assert beside(0.005, 1.0) == 0.0
    assert shy_turn([(-0.035, 0.001)], EPUCK) == 0.0
