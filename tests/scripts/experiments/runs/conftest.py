"""A map that runs are made on."""

from __future__ import annotations

from pathlib import Path

import pytest
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world


@pytest.fixture(scope="session")
def settings() -> dict[str, str | float]:
    """What the settings of a job say of the map, and that the kinematic twin is driven."""
    return {
        "map world": "env1",
        "map profile": "default",
        "map noise": "thesis",
        "map noise_scale": 1.0,
        "engine": "kinematic",
    }


@pytest.fixture(scope="session")
def env1(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """env1 mapped."""
    path = tmp_path_factory.mktemp("beyond") / "env1.tolman"
    map_world(MapRequest(world="env1", output=path, global_only=True, engine="kinematic", seed=2))
    return path
