from __future__ import annotations

import pytest
from tolman.world import Pose, WheelCommand, open_world

from ..arrangements import SQUARE


def test_encoders_count_every_tick_though_they_are_read_seldom() -> None:
    sensing = {"encoders": {"interval": 0.096}}
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0), sensing=sensing)
    counts = []
    for _ in range(7):
        world.robots[0].act(WheelCommand(100, -100))
        world.step()
        counts.append(world.robots[0].sense().encoders)
    assert counts[5] == counts[6] == pytest.approx((6 * 3.2, -6 * 3.2))
    assert counts[2] == counts[3] == counts[4]
