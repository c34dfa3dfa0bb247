"""Round and straight walls from what the side and the diagonal sensor see of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent.perception.round_wall import CurvedWall

SIDE, DIAGONAL = -0.5 * math.pi, -0.8
STEP = 0.001


def hits(x: float, y: float, heading: float, curvature: float) -> list[tuple[float, float]]:
    """What the sensors of a robot at (x, y) hit of a wall through the origin, below y = 0, convex if > 0."""
    found = []
    for bearing in (SIDE, DIAGONAL):
        u, v = math.cos(heading + bearing), math.sin(heading + bearing)
        if curvature == 0.0:
            reach = -y / v
        else:
            radius = 1.0 / curvature
            middle = u * x + v * (y + radius)
            square = middle * middle - x * x - (y + radius) ** 2 + radius * radius
            if square < 0.0:
                continue
            reach = -middle - math.copysign(math.sqrt(square), radius)
        if reach < 0.035 + 0.065:
            found.append((reach, bearing))
    return found


def drive(curvature: float, seed: int, length: float = 0.3, noise: float = 0.02) -> CurvedWall:
    """Straight ahead at first, then around at the set distance from the wall, whatever is believed."""
    rng = np.random.default_rng(seed)
    wall = CurvedWall(0.057, 0.0, 0.03)
    x, y, heading = 0.0, 0.057, 0.0
    center = -1.0 / curvature if curvature else 0.0
    for _ in range(round(length / STEP)):
        if curvature:
            along = math.atan2(y - center, x) - 0.5 * math.pi
            off = math.copysign(math.hypot(x, y - center), curvature) - 1.0 / curvature - 0.057
        else:
            along, off = 0.0, y - 0.057
        wanted = along - max(-0.3, min(0.3, 6.0 * off))
        turn = max(-0.02, min(0.02, wanted - heading))
        heading += turn
        x, y = x + STEP * math.cos(heading), y + STEP * math.sin(heading)
        wall.predict(STEP, turn + rng.normal(0.0, 0.002))
        seen = hits(x, y, heading, curvature)
        wall.see((0.035 + (reach - 0.035) * (1.0 + rng.normal(0.0, noise)), b) for reach, b in seen)
    return wall


@pytest.mark.parametrize("radius", [0.05, 0.08, 0.15, 0.25])
def test_a_pillar_is_known_for_round_and_how_round(radius: float) -> None:
    for seed in range(5):
        wall = drive(1.0 / radius, seed)
        assert wall.is_round
        assert wall.distance == pytest.approx(0.057, abs=0.008)
        assert wall.bend == pytest.approx(1.0 / (radius + 0.057), rel=0.3)


@given(seed=st.integers(0, 10_000), noise=st.floats(0.005, 0.03))
@settings(max_examples=40, deadline=None)
def test_a_straight_wall_is_never_taken_for_round(seed: int, noise: float) -> None:
    wall = drive(0.0, seed, 0.8, noise)
    assert not wall.is_round
    assert wall.distance == pytest.approx(0.057, abs=0.004)
    assert abs(wall.angle) < 0.08


def test_beyond_a_round_wall_a_straight_one_is_straight_again() -> None:
    wall = drive(1.0 / 0.1, 3)
    assert wall.is_round
    for _ in range(400):
        wall.predict(STEP, -wall.angle)
        wall.see(hits(0.0, 0.057, 0.0, 0.0))
    assert not wall.is_round
