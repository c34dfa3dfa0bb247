from __future__ import annotations

import json
import math

import numpy as np
import pytest
from tolman.world import EPUCK, EPUCK2, Pose, WheelCommand, World, WorldSpec, open_world
from tolman.world.sensors.range_finder import CONE, FARTHEST, NOISE
from tolman.world.spec import Box, room_walls

from ..arrangements import SQUARE


def opened(spec: WorldSpec = SQUARE, x: float = 1.0, heading: float = 0.0, noise: str = "none") -> World:
    return open_world(spec, noise=noise, engine="kinematic", start=Pose(x, 1.0, heading), geometry=EPUCK2)


def distance(world: World) -> float:
    return world.robots[0].sense().readings["range"][0]


@pytest.mark.parametrize("rays", ["auto", "numpy"])
@pytest.mark.parametrize("gap", [1e-6, 0.005, 0.1, 0.5, 1.5])
def test_it_reads_the_distance_to_a_wall_ahead(rays: str, gap: float) -> None:
    start = Pose(2.0 - EPUCK.body_radius - gap, 1.0, 0.0)
    world = open_world(
        SQUARE, noise="none", engine="kinematic", start=start, rays=rays, sensing={"range": {}}
    )
    assert distance(world) == pytest.approx(gap, rel=0.01, abs=1e-5)


def test_beyond_two_meters_it_reads_two_meters() -> None:
    large = WorldSpec("large", room_walls(6.0, 6.0))
    assert distance(opened(large)) == FARTHEST
    assert distance(opened(large, noise="thesis")) <= FARTHEST


def test_it_reads_the_nearest_thing_in_its_cone_and_nothing_beside_it() -> None:
    for angle, seen in ((0.4 * CONE, True), (0.7 * CONE, False)):
        x, y = 1.0 + 0.4 * math.cos(angle), 1.0 + 0.4 * math.sin(angle)
        post = WorldSpec("post", (*room_walls(2.0, 2.0), Box(x, y, 0.04, 0.04)))
        assert (distance(opened(post)) < 0.4) == seen


def test_it_is_measured_every_third_tick_and_read_a_tick_later() -> None:
    world = opened()
    found = []
    for _ in range(10):
        world.robots[0].act(WheelCommand(500, 500))
        world.step()
        found.append(distance(world))
    fresh = [k + 1 for k in range(1, 10) if found[k] != found[k - 1]]
    assert fresh == [4, 7, 10]


def test_its_noise_is_a_share_of_the_distance() -> None:
    world, truth = opened(noise="thesis"), distance(opened())
    found = []
    for _ in range(900):
        world.step()
        found.append(distance(world))
    assert np.mean(found) == pytest.approx(truth, rel=0.01)
    assert np.std(found) / truth == pytest.approx(NOISE, rel=0.15)


def test_a_robot_without_one_has_no_reading() -> None:
    world = open_world(SQUARE, engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    assert world.robots[0].sense().readings == {}


def test_restoring_a_state_repeats_its_readings() -> None:
    world = opened(noise="thesis")
    for _ in range(5):
        world.step()
    state = json.loads(json.dumps(world.state()))
    runs = []
    for again in (world, opened(noise="thesis")):
        again.restore(state)
        run = [distance(again)]
        for _ in range(20):
            again.robots[0].act(WheelCommand(300, 280))
            again.step()
            run.append(distance(again))
        runs.append(run)
    assert runs[0] == runs[1]
    assert len(set(runs[0])) > 5
