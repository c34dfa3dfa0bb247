from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent.perception.compass import difference, sensitivity, turn_between

from ..sceneries import FIELD, panorama


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 1000), st.floats(-0.3, 0.3))
def test_a_turn_on_the_spot_is_recovered(seed: int, turned: float) -> None:
    turn = turn_between(panorama(seed), panorama(seed, turned), FIELD)
    assert turn is not None
    assert turn.angle == pytest.approx(turned, abs=math.radians(0.6))
    assert turn.sharpness > 0.0


def test_other_scenery_fits_worse_than_the_same() -> None:
    same = turn_between(panorama(1), panorama(1, 0.1), FIELD)
    other = turn_between(panorama(1), panorama(2), FIELD)
    assert same is not None
    assert other is None or other.sharpness < same.sharpness


def test_a_turn_beyond_its_range_is_not_told_as_a_small_one() -> None:
    turn = turn_between(panorama(5), panorama(5, math.radians(24.0)), FIELD)
    assert turn is None or turn.angle > math.radians(15.0)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.1, 0.9), st.floats(0.0, 0.05))
def test_plain_views_tell_nothing(grey: float, brighter: float) -> None:
    plain = np.full((4, 16, 16), grey, dtype=np.float32)
    assert turn_between(plain, plain + np.float32(brighter), FIELD) is None


@given(seed=st.integers(0, 1000), turned=st.floats(-0.1, 0.1))
@settings(max_examples=40, deadline=None)
def test_the_same_surroundings_differ_by_little_however_turned(seed: int, turned: float) -> None:
    here = panorama(seed)
    alike = difference(here, panorama(seed, turned=turned), FIELD)
    assert alike < 0.3 * difference(here, panorama(seed + 1), FIELD)
    assert difference(here, here, FIELD) < 1e-6


def test_each_view_may_be_turned_by_itself() -> None:
    views = panorama(2)
    drifting = np.stack([panorama(2, turned=0.02 * k)[k] for k in range(4)])
    assert difference(views, drifting, FIELD) < 0.01


def test_sensitivity_grows_with_the_turn_and_vanishes_where_all_looks_alike() -> None:
    changes = [sensitivity(panorama(5), FIELD, math.radians(turn)) for turn in (0.0, 1.0, 3.0)]
    assert changes[0] < 1e-6 < changes[1] < changes[2]
    assert sensitivity(np.full((4, 16, 16), 0.5, dtype=np.float32), FIELD, 0.02) < 1e-6
