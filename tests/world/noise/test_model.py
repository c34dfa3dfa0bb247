from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.world import PRESETS, Noise, Pose, WheelCommand, WorldError, WorldSpec, open_world
from tolman.world.noise.model import resolve_noise
from tolman.world.physics.simulated import SimulatedWorld
from tolman.world.spec import room_walls

LARGE = WorldSpec("large", room_walls(40.0, 40.0))


def opened(**options: Any) -> SimulatedWorld:
    world = open_world(LARGE, engine="kinematic", start=Pose(20.0, 20.0, 0.0), **options)
    assert isinstance(world, SimulatedWorld)
    return world


def test_encoder_noise_is_uniform_within_ten_percent_and_exact_on_average() -> None:
    world = opened(noise={"encoder": 0.1}, seed=1)
    steps = []
    before = 0.0
    for _ in range(2000):
        world.robots[0].act(WheelCommand(200, 200))
        world.step()
        now = world.robots[0].sense().encoders[0]
        steps.append((now - before) / 6.4)
        before = now
    assert 0.9 <= min(steps) < 0.91
    assert 1.09 < max(steps) <= 1.1
    assert np.mean(steps) == pytest.approx(1.0, abs=0.005)
    assert np.std(steps) == pytest.approx(0.1 / np.sqrt(3), rel=0.05)


@given(seed=st.integers(0, 2**32 - 1), mismatch=st.floats(0.0, 0.5))
def test_mismatch_is_antisymmetric(seed: int, mismatch: float) -> None:
    left, right = opened(noise=Noise(mismatch=mismatch), seed=seed).robots[0].radius_factors
    assert (left + right) / 2 == pytest.approx(1.0, abs=1e-12)
    assert abs(left - right) <= mismatch + 1e-12


def test_a_mismatch_bends_the_way_but_the_encoders_do_not_tell() -> None:
    world = opened(noise={"unequal_wheels": 0.02})
    for _ in range(200):
        world.robots[0].act(WheelCommand(300, 300))
        world.step()
    left, right = world.robots[0].sense().encoders
    assert left == right
    assert world.true_pose().heading > 0.08  # the larger right wheel turns it left


def test_unequal_wheels_are_in_the_stated_ratio() -> None:
    left, right = opened(noise={"unequal_wheels": 0.04}).robots[0].radius_factors
    assert right / left == pytest.approx(1.04)
    assert left + right == pytest.approx(2.0)


def test_slip_shortens_the_way_but_not_the_count() -> None:
    world = opened(noise={"slip": 0.2})
    for _ in range(500):
        world.robots[0].act(WheelCommand(300, 300))
        world.step()
    driven = world.true_pose().distance_to(Pose(20.0, 20.0, 0.0))
    counted = world.robots[0].sense().encoders[0] * world.geometry.distance_per_step
    assert driven / counted == pytest.approx(0.9, abs=0.01)


def test_no_noise_means_none() -> None:
    assert resolve_noise("none", 3.0) == Noise()


def test_scaling_scales_every_value() -> None:
    assert resolve_noise("thesis", 2.0) == Noise(
        encoder=0.2,
        mismatch=2 * PRESETS["thesis"].mismatch,
        infrared=2.0,
        infrared_floor=10.0,
        camera=0.02,
        accelerometer=0.1,
        sensors=2.0,
    )


@pytest.mark.parametrize(
    ("noise", "problem"),
    [
        ("theses", "did you mean 'thesis'"),
        ({"slipp": 0.1}, "did you mean 'slip'"),
        ({"slip": 2.0}, "outside 0 to 1"),
        ({"slip": "much"}, "must be a number"),
        ({"encoder": float("nan")}, "outside"),
        ({"preset": "nothing"}, "unknown noise preset"),
        (Noise(encoder=-1.0), "outside"),
    ],
)
def test_a_wrong_noise_is_explained(noise: Any, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        open_world("env1", engine="kinematic", noise=noise)


@pytest.mark.parametrize("scale", [-1.0, float("nan"), 1e6])
def test_a_wrong_noise_scale_is_explained(scale: float) -> None:
    with pytest.raises(WorldError, match="noise scale"):
        open_world("env1", engine="kinematic", noise_scale=scale)
