from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tolman.agent.behavior import Context
from tolman.plugins.isolation.wire import pack_tick, unpack_tick
from tolman.plugins.testing import percept
from tolman.world.robot import EPUCK, Pose


def context() -> Context:
    return Context(EPUCK, lambda _: True, lambda: np.zeros((16, 16), np.float32), np.random.default_rng(0))


@pytest.mark.parametrize("readings", [{}, {"range": (1.25,), "ground": (0.0, 1 / 3, -2.5)}])
def test_a_percept_and_the_context_cross_to_the_bit(readings: dict[str, tuple[float, ...]]) -> None:
    here, there = context(), context()
    here.time, here.pose, here.distance, here.in_control = 0.224, Pose(0.1, 1 / 3, -2.0), 0.004, True
    sensed = replace(percept(right=0.02, tick=7), readings=readings)
    assert unpack_tick(pack_tick(sensed, here), there) == sensed
    assert (there.time, there.pose, there.distance, there.in_control) == (
        here.time,
        here.pose,
        here.distance,
        here.in_control,
    )
