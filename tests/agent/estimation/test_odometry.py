from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.estimation.odometry import PathIntegrator
from tolman.world.robot import EPUCK, Pose, wrap_angle

coordinates = st.floats(-10.0, 10.0)
headings = st.floats(-math.pi, math.pi)
poses = st.builds(Pose, coordinates, coordinates, headings)


def integrate(wheels: list[tuple[float, float]], ticks: int, **options: float) -> PathIntegrator:
    """Wheels: steps of (left, right), each spread evenly over so many ticks."""
    integrator = PathIntegrator(EPUCK, **options)  # type: ignore[arg-type]
    left = right = 0.0
    integrator.update((left, right))
    for steps_left, steps_right in wheels:
        for _ in range(ticks):
            left, right = left + steps_left / ticks, right + steps_right / ticks
            integrator.update((left, right))
    return integrator


@given(poses, poses)
def test_relative_undoes_compose(pose: Pose, other: Pose) -> None:
    seen = pose.relative(other)
    back = pose.compose(seen.x, seen.y, seen.heading)
    assert back.distance_to(other) < 1e-9
    assert abs(wrap_angle(back.heading - other.heading)) < 1e-9


@given(poses, poses, poses)
def test_compose_is_associative(a: Pose, b: Pose, c: Pose) -> None:
    inner = b.compose(c.x, c.y, c.heading)
    outer = a.compose(b.x, b.y, b.heading)
    left = a.compose(inner.x, inner.y, inner.heading)
    right = outer.compose(c.x, c.y, c.heading)
    assert left.distance_to(right) < 1e-9
    assert abs(wrap_angle(left.heading - right.heading)) < 1e-9


@given(st.floats(-1e6, 1e6))
def test_a_wrapped_angle_is_the_same_angle_in_the_half_open_circle(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-6)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-6)


@given(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0))
def test_small_ticks_follow_the_exact_arc(left: float, right: float) -> None:
    integrator = integrate([(left, right)], ticks=200)
    way_left, way_right = left * EPUCK.distance_per_step, right * EPUCK.distance_per_step
    length, turn = 0.5 * (way_left + way_right), (way_right - way_left) / EPUCK.track
    chord = length * (math.sin(0.5 * turn) / (0.5 * turn) if abs(turn) > 1e-9 else 1.0)
    expected = Pose(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn))
    assert integrator.pose.distance_to(expected) < 2e-5
    assert integrator.heading == pytest.approx(turn, abs=1e-9)
    assert integrator.travelled == pytest.approx(length, abs=1e-9)


@given(st.lists(st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0)), max_size=8))
def test_driving_back_the_same_way_ends_where_it_began(wheels: list[tuple[float, float]]) -> None:
    back = [(-left, -right) for left, right in reversed(wheels)]
    integrator = integrate([*wheels, *back], ticks=3)
    assert integrator.pose.distance_to(Pose()) < 1e-9
    assert integrator.heading == pytest.approx(0.0, abs=1e-9)


@given(st.floats(-0.02, 0.02))
def test_a_known_mismatch_makes_a_straight_way_straight(mismatch: float) -> None:
    step = EPUCK.distance_per_step
    left, right = 1.0 / step / (1.0 - 0.5 * mismatch), 1.0 / step / (1.0 + 0.5 * mismatch)
    told = integrate([(left, right)], ticks=10, mismatch=mismatch)
    assert told.pose.distance_to(Pose(1.0, 0.0, 0.0)) < 1e-9
    untold = integrate([(left, right)], ticks=10)
    assert untold.heading == pytest.approx(-mismatch / EPUCK.track, rel=0.01)


def test_the_first_percept_only_sets_the_zero() -> None:
    integrator = PathIntegrator(EPUCK, Pose(1.0, 2.0, 0.5))
    integrator.update((12345.0, -999.0))
    assert integrator.pose == Pose(1.0, 2.0, 0.5)
    assert integrator.distance == integrator.turn == integrator.travelled == 0.0


def test_reset_moves_the_pose_but_not_the_way_travelled() -> None:
    integrator = integrate([(100.0, 100.0)], ticks=1)
    travelled = integrator.travelled
    integrator.reset(Pose(3.0, 4.0, 1.0))
    assert integrator.pose == Pose(3.0, 4.0, 1.0)
    assert integrator.travelled == travelled > 0.0


def test_a_restored_state_goes_on_to_the_bit() -> None:
    whole = integrate([(100.0, 130.0)], ticks=7, mismatch=0.003)
    again = PathIntegrator(EPUCK)
    again.restore(json.loads(json.dumps(whole.state())))
    for encoders in ((150.0, 190.0), (151.5, 240.25)):
        whole.update(encoders)
        again.update(encoders)
    assert again.state() == whole.state()


def test_a_state_from_before_the_first_percept_is_restored_too() -> None:
    again = PathIntegrator(EPUCK)
    again.restore(json.loads(json.dumps(PathIntegrator(EPUCK).state())))
    again.update((500.0, 500.0))
    assert again.travelled == 0.0
