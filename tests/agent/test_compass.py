from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tolman.agent.compass import turn_between
from tolman.world.robot import EPUCK

FIELD = EPUCK.camera_field_of_view


def panorama(seed: int, turned: float = 0.0, width: int = 16) -> NDArray[np.float32]:
    """Four views (4, 16, width) of smooth scenery all around, taken after turning by `turned` (rad)."""
    rng = np.random.default_rng(seed)
    orders = np.arange(1, 9)
    amplitude = rng.normal(0.0, 1.0, (16, 8)) / orders
    phase = rng.uniform(0.0, math.tau, (16, 8))
    focal = 0.5 * width / math.tan(0.5 * FIELD)
    bearing = np.arctan((0.5 * width - np.arange(width) - 0.5) / focal)
    views = [
        (
            amplitude[:, None, :] * np.cos(orders * (bearing[None, :, None] + direction) + phase[:, None, :])
        ).sum(2)
        for direction in turned + 0.5 * math.pi * np.arange(4)
    ]
    return (0.5 + 0.1 * np.array(views)).astype(np.float32)


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
