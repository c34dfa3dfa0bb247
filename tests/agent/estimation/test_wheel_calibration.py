from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent import PathIntegrator
from tolman.agent.estimation.wall_segments import WallSegmentMeter
from tolman.agent.estimation.wheel_calibration import MismatchEstimate, is_even
from tolman.agent.events import CornerReached, WallMet
from tolman.world.robot import EPUCK, Pose

TRACK = 0.053
ORIGIN = Pose()


def drive(estimate: MismatchEstimate, true: float, length: float, slip: float = 0.0) -> None:
    """Along a straight wall: odometry that uses the estimate turns by what is left of the mismatch."""
    estimate.straight(TRACK, (estimate.value - true) * length / TRACK + slip, length)


@given(st.floats(-0.02, 0.02), st.lists(st.floats(0.1, 1.0), min_size=20, max_size=30))
def test_it_converges_to_the_true_mismatch(true: float, lengths: list[float]) -> None:
    estimate = MismatchEstimate()
    for length in lengths:
        drive(estimate, true, length)
    assert abs(estimate.value - true) <= 0.1 * abs(true) + 1e-9


def test_with_noise_it_ends_as_near_as_its_variance_says() -> None:
    rng = np.random.default_rng(0)
    ratios = []
    for _ in range(200):
        estimate, true = MismatchEstimate(), rng.uniform(-0.01, 0.01)
        for _ in range(10):
            ticks = 0.4 / 0.00096
            slip = rng.normal(0.0, math.sqrt(2.0 * estimate.tangent**2 + ticks * estimate.tick_turn**2))
            drive(estimate, true, 0.4, slip)
        ratios.append((estimate.value - true) ** 2 / estimate.variance)
    assert 0.6 < float(np.mean(ratios)) < 1.5


@given(st.floats(-0.01, 0.01), st.floats(0.06, 2.0))
def test_every_stretch_lowers_the_variance(true: float, length: float) -> None:
    estimate = MismatchEstimate()
    before = estimate.variance
    drive(estimate, true, length)
    assert estimate.variance < before


@pytest.mark.parametrize(("turned", "length"), [(0.3, 0.04), (2.0, 0.4), (-2.0, 0.4)])
def test_short_stretches_and_wild_turns_teach_nothing(turned: float, length: float) -> None:
    estimate = MismatchEstimate(0.004, 0.0001)
    estimate.straight(TRACK, turned, length)
    assert (estimate.value, estimate.variance) == (0.004, 0.0001)


def corner(
    kind: str = "concave", max_heading_change: float = 0.0, length: float = 0.8, heading: float = 0.0
) -> CornerReached:
    return CornerReached(
        time=1.0,
        side="right",
        kind=kind,
        path_length=length,
        heading=heading,
        turn=0.0,
        max_heading_change=max_heading_change,
    )


def test_a_turn_that_the_worst_wheels_make_is_explained_until_the_wheels_are_known() -> None:
    estimate = MismatchEstimate()
    assert estimate.explains(TRACK, 0.021 / TRACK, 1.0)
    assert not estimate.explains(TRACK, 2.0, 1.0)
    for _ in range(6):
        drive(estimate, 0.0, 1.0)
    assert not estimate.explains(TRACK, 0.021 / TRACK, 1.0)


def test_only_walls_that_bend_nowhere_sharply_teach_anything() -> None:
    assert is_even(corner())
    assert not is_even(corner(max_heading_change=0.2))
    assert not is_even(corner(kind="bend"))


def meter(left: Pose = ORIGIN) -> tuple[WallSegmentMeter, PathIntegrator]:
    odometry = PathIntegrator(EPUCK, left)
    measure = WallSegmentMeter(odometry, TRACK)
    measure.leave()
    measure.wall = WallMet(time=0.0, side="right", heading=left.heading)
    return measure, odometry


def test_a_straight_wall_has_no_shape_and_teaches_the_mismatch() -> None:
    measure, odometry = meter()
    odometry.reset(Pose(0.8, 0.04, 0.1))
    event, way = measure.arrive(corner(heading=0.1)) or (None, None)
    assert event is not None
    assert way is None
    assert measure.mismatch.value < -0.003
    assert odometry.mismatch == measure.mismatch.value


def test_a_wall_with_a_blunt_corner_keeps_its_shape_and_teaches_nothing() -> None:
    measure, odometry = meter(Pose(1.0, 1.0, 0.5 * math.pi))
    odometry.reset(Pose(1.1, 1.7, 0.5 * math.pi - 0.4))
    arrived = measure.arrive(corner(max_heading_change=0.4, heading=0.5 * math.pi - 0.4))
    assert arrived is not None
    way = arrived[1]
    assert way is not None
    assert (way.dx, way.dy, way.dtheta) == pytest.approx((0.7, -0.1, -0.4))
    assert measure.mismatch.value == 0.0


def test_a_bend_that_the_wheels_may_have_made_is_none_and_its_way_goes_on() -> None:
    measure, odometry = meter()
    odometry.reset(Pose(1.8, 0.9, 1.05))
    assert measure.arrive(corner("bend", length=2.2, heading=1.05)) is None
    measure.wall = WallMet(time=2.0, side="right", heading=1.05)
    odometry.reset(Pose(2.0, 1.3, 1.2))
    arrived = measure.arrive(corner(length=0.4, heading=1.2))
    assert arrived is not None
    assert arrived[0].path_length == pytest.approx(2.6)


def test_driving_there_and_back_along_a_bent_wall_tells_the_wheels_from_the_wall() -> None:
    """0.5 m of a circle of 0.5 m radius, by wheels that differ by 1 %."""
    measure, odometry = meter()
    assert measure.unsure
    mismatch, driven = 0.01, 1.0
    swing = 0.5 / 0.5 - mismatch * 0.5 / TRACK
    measure.calibrate(-mismatch * driven / TRACK, driven, 0.5)
    assert not measure.unsure
    assert measure.mismatch.value == pytest.approx(mismatch, rel=0.1)
    here = swing - mismatch * driven / TRACK
    odometry.reset(Pose(0.4, 0.2, here))
    measure.leave()
    arrived = measure.arrive(corner("bend", length=0.5, heading=here))
    assert arrived is not None
    assert arrived[1] is not None
    assert arrived[1].dtheta == pytest.approx(1.0, abs=0.02)
