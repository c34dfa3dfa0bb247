from __future__ import annotations

import hashlib
import json
import math
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tolman.world import (
    PRESETS,
    PlacementError,
    Pose,
    WheelCommand,
    World,
    WorldError,
    WorldSpec,
    open_world,
)
from tolman.world.spec import Box, MovableBox, room_walls

ENGINES = ({"engine": "kinematic"}, {"model": "wheels"}, {"model": "planar"})


def wander(world: World, ticks: int, seed: int = 1) -> None:
    """Random speeds for every robot, changed every 20 ticks; walls are met."""
    random = np.random.default_rng(seed)
    for tick in range(ticks):
        for robot in world.robots:
            if tick % 20 == 0:
                robot.act(WheelCommand(*random.uniform(-400, 1000, 2).tolist()))
        world.step()


@pytest.mark.parametrize("options", ENGINES)
def test_restoring_a_state_repeats_the_run_to_the_bit(options: dict[str, Any]) -> None:
    world = open_world("env1", seed=4, start=Pose(0.06, 0.06, -2.3), **options)
    wander(world, 150)
    saved = json.loads(json.dumps(world.state()))
    wander(world, 200, seed=2)
    after = world.state()
    world.restore(saved)
    wander(world, 200, seed=2)
    assert world.state() == after
    fresh = open_world("env1", seed=99, **options)
    fresh.restore(saved)
    wander(fresh, 200, seed=2)
    assert fresh.state() == after
    assert world.collisions() > 0


@pytest.mark.parametrize("options", ENGINES)
def test_a_robot_that_was_rolling_stops_the_same_way_after_restoring(options: dict[str, Any]) -> None:
    states = []
    world = open_world("env1", seed=4, **options)
    world.robots[0].act(WheelCommand(230, 235))
    world.step()
    saved = json.loads(json.dumps(world.state()))
    for again in (world, open_world("env1", seed=99, **options)):
        if again is not world:
            again.restore(saved)
        again.robots[0].act(WheelCommand(0, 0))
        again.step()
        states.append(again.state())
    assert states[0] == states[1]


@pytest.mark.parametrize("options", ENGINES)
def test_several_robots_and_boxes_repeat_to_the_bit(options: dict[str, Any]) -> None:
    spec = WorldSpec(
        "crowd",
        room_walls(1.0, 1.0),
        robots=(Pose(0.7, 0.3, 2.0), Pose(0.3, 0.7, -1.0)),
        movable=(MovableBox(Box(0.5, 0.5, 0.08, 0.08)),),
    )
    states = []
    for _ in range(2):
        world = open_world(spec, start=Pose(0.3, 0.3, 0.5), **options)
        wander(world, 150)
        states.append(world.state())
    assert states[0] == states[1]


_SCRIPT = """
import hashlib, json
from tolman.world import WheelCommand, open_world
world = open_world("env2", seed=7)
for tick in range(120):
    world.robots[0].act(WheelCommand(300 + tick, 500 - 3 * tick))
    world.step()
view = world.robots[0].look().tobytes()
print(hashlib.sha256(json.dumps(world.state()).encode() + view).hexdigest())
"""


def test_two_processes_give_the_same_run() -> None:
    digests = {
        subprocess.run([sys.executable, "-c", _SCRIPT], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    }
    assert len(digests) == 1
    assert len(digests.pop().strip()) == hashlib.sha256().digest_size * 2


def test_another_seed_gives_another_run() -> None:
    ends = []
    for seed in (0, 1):
        world = open_world("env1", seed=seed, engine="kinematic")
        wander(world, 50)
        ends.append(world.robots[0].sense())
    assert ends[0] != ends[1]


def test_sensing_and_looking_do_not_change_the_world() -> None:
    states = []
    for asks in (0, 3):
        world = open_world("env1", engine="kinematic", noise=replace(PRESETS["thesis"], camera=0.0))
        for _ in range(20):
            for _ in range(asks):
                world.robots[0].sense()
                world.robots[0].look(8, 8)
            world.robots[0].act(WheelCommand(100, 120))
            world.step()
        states.append(world.state())
    assert states[0] == states[1]


@pytest.mark.parametrize("change", [{"version": 0}, {"kind": "other"}, {"world": "0" * 64}, {"robots": []}])
def test_a_state_of_another_world_is_refused(change: dict[str, Any]) -> None:
    world = open_world("env1", engine="kinematic")
    with pytest.raises(WorldError, match="this state"):
        world.restore({**world.state(), **change})


def test_a_damaged_state_is_refused() -> None:
    world = open_world("env1", engine="kinematic")
    state = world.state()
    del state["robots"][0]["encoders"]
    with pytest.raises(WorldError, match="damaged"):
        world.restore(state)


@pytest.mark.parametrize("options", ENGINES)
@pytest.mark.parametrize("pose", [Pose(0.02, 0.5, 0.0), Pose(0.36, 0.3, 0.0), Pose(math.nan, 0.5, 0.0)])
def test_a_start_in_a_wall_is_refused(options: dict[str, Any], pose: Pose) -> None:
    with pytest.raises(PlacementError):
        open_world("env1", start=pose, **options)
    world = open_world("env1", **options)
    with pytest.raises(PlacementError):
        world.place(pose)


def test_robots_and_boxes_cannot_start_inside_each_other() -> None:
    close = WorldSpec("close", room_walls(1.0, 1.0), robots=(Pose(0.55, 0.5, 0.0),))
    with pytest.raises(PlacementError, match="overlap robot 0"):
        open_world(close, engine="kinematic", start=Pose(0.5, 0.5, 0.0))
    box = WorldSpec("box", room_walls(1.0, 1.0), movable=(MovableBox(Box(0.5, 0.5, 0.2, 0.2)),))
    with pytest.raises(PlacementError, match="movable box"):
        open_world(box, engine="kinematic", start=Pose(0.5, 0.5, 0.0))


@pytest.mark.parametrize("options", ENGINES)
def test_placing_stands_the_robot_still_and_keeps_its_encoders(options: dict[str, Any]) -> None:
    world = open_world("env1", noise="none", **options)
    world.robots[0].act(WheelCommand(400, 400))
    world.step()
    encoders = world.robots[0].sense().encoders
    world.place(Pose(0.6, 0.4, 1.0))
    assert world.robots[0].sense().encoders == encoders
    world.step()
    assert world.true_pose().distance_to(Pose(0.6, 0.4, 1.0)) < 1e-6


@pytest.mark.parametrize("options", ENGINES)
def test_a_closed_world_does_not_step(options: dict[str, Any]) -> None:
    world = open_world("env1", **options)
    world.close()
    with pytest.raises(WorldError, match="closed"):
        world.step()


def test_a_world_is_closed_at_the_end_of_with() -> None:
    with open_world("env1", engine="kinematic") as world:
        world.step()
    with pytest.raises(WorldError, match="closed"):
        world.step()


def test_a_world_says_what_it_is() -> None:
    world = open_world("env1")
    for _ in range(384):
        world.step()
    assert repr(world) == "World('env1', 1 robot, dart wheels, t=12.3 s)"
    world.close()
    assert repr(world) == "World('env1', 1 robot, dart wheels, t=12.3 s, closed)"
    crowd = WorldSpec("crowd", room_walls(1.0, 1.0), robots=(Pose(0.7, 0.3, 2.0),))
    twins = open_world(crowd, engine="kinematic", start=Pose(0.3, 0.3, 0.5))
    assert repr(twins) == "World('crowd', 2 robots, kinematic, t=0.0 s)"
