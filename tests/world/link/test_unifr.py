"""A third party's client, unmodified, drives the server: `unifr-api-epuck` from the package index.

It is installed without its dependencies: `pip install --no-deps unifr-api-epuck`; without it this is skipped.
"""

import importlib.util
import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from tolman.world import Pose, open_world
from tolman.world.link.device import Device
from tolman.world.link.packets import Sensors
from tolman.world.link.server import Server
from tolman.world.link.units import E_PUCK2
from tolman.world.spec import WorldSpec, room_walls

CLIENT = Path(__file__).with_name("unifr_client.py")
MISSING = importlib.util.find_spec("unifr_api_epuck") is None
SQUARE = WorldSpec("square", room_walls(1.0, 1.0))


class Watched(Device):
    """Keeps what it truly was when it answered: (left, right) steps and infrared."""

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.truth: dict[tuple[int, ...], tuple[int, ...]] = {}

    def sensors(self) -> Sensors:
        percept = self.robot.sense()
        left, right = (round(steps) for steps in percept.encoders)
        self.truth[left, right] = tuple(round(value) for value in percept.infrared)
        return super().sensors()


@pytest.mark.slow
@pytest.mark.skipif(
    importlib.util.find_spec("unifr_api_epuck") is None, reason="unifr-api-epuck is not installed"
)
def test_an_unmodified_client_reads_and_drives() -> None:
    world = open_world(SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=Pose(0.5, 0.06, 0.0))
    device = Watched(world)
    server = Server(device, fast=True)
    over = threading.Event()
    thread = threading.Thread(target=server.serve, args=(over.is_set,), daemon=True)
    thread.start()
    try:
        done = subprocess.run(
            [sys.executable, CLIENT, str(server.port), "400", "100"],
            capture_output=True,
            text=True,
            timeout=120,
        )
    finally:
        over.set()
        thread.join(10)
    assert done.returncode == 0, done.stderr
    found = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
    assert found["answered"] == found["asked"] == 408
    assert (found["images"], found["bad"]) == (4, 0)
    for steps, proximity in zip(found["steps"], found["proximity"], strict=True):
        assert device.truth[tuple(steps)] == tuple(proximity)
    assert max(max(steps) for steps in found["steps"]) > 100
    assert 2900 < found["battery"] < 3440
    assert server.served == 1
