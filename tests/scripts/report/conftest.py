from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest
from tolman.scripts.session.requests import GoRequest, MapRequest
from tolman.scripts.session.simulation import go_to, map_world


class Runs(NamedTuple):
    """A mapping of the first room's first two nodes, its map, and a trip by it of a robot that is lost."""

    mapping: Path
    map: Path
    trip: Path


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    folder = tmp_path_factory.mktemp("runs")
    found = Runs(folder / "run.mcap", folder / "map.tolman", folder / "trip.mcap")
    map_world(MapRequest(world="env1", output=found.map, max_nodes=2, record=found.mapping))
    go_to(GoRequest(map=found.map, to=1, lost=True, max_time=20.0, record=found.trip))
    return found
