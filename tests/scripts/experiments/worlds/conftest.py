"""What is true of every room that is drawn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tolman.world.geometry import Plan, cast
from tolman.world.robot import EPUCK
from tolman.world.spec import WorldSpec


@pytest.fixture(scope="session")
def is_closed_around_both_starts() -> Callable[[WorldSpec], None]:
    """Asserts that there is room for the robot at both starts, and walls all around."""

    def check(spec: WorldSpec) -> None:
        plan = Plan(spec.shapes)
        turns = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False) + 0.013
        directions = np.stack((np.cos(turns), np.sin(turns)), 1)
        for side in ("right", "left"):
            pose = spec.start(side)
            assert plan.clearance(pose.x, pose.y) > EPUCK.body_radius
            origins = np.broadcast_to(np.array((pose.x, pose.y)), directions.shape)
            assert np.isfinite(cast(origins, directions, plan.segments)).all()

    return check
