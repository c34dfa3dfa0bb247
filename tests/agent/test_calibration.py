from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.calibration import MismatchEstimate

TRACK = 0.053


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
