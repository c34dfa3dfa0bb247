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
    EPUCK,
    PRESETS,
    PlacementError,
    Pose,
    SimulationError,
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


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused(speed: float) -> None:
    world = open_world("env1", engine="kinematic")
    with pytest.raises(ValueError, match="finite"):
        world.robots[0].act(WheelCommand(speed, 0.0))


def test_commands_are_clamped_to_the_robots_top_speed() -> None:
    world = open_world("env1", engine="kinematic", noise="none", start=Pose(0.15, 0.3, math.pi / 2))
    world.robots[0].act(WheelCommand(1e9, 1e9))
    world.step()
    assert world.true_pose().y - 0.3 == pytest.approx(EPUCK.max_speed * EPUCK.distance_per_step * 0.032)


def test_a_robot_that_tips_ends_the_run_with_an_error() -> None:
    from tolman.world.physics.dart import DartWorld

    world = open_world("env1", noise="none")
    assert isinstance(world, DartWorld)
    state = world.state()
    state["bodies"]["bodies"][0][0][0] = 1.2
    world.restore(state)
    with pytest.raises(SimulationError, match="tipped or flew off"):
        world.step()


def test_a_robot_that_is_nowhere_ends_the_run_with_an_error() -> None:
    from tolman.world.physics.dart import DartWorld

    world = open_world("env1", noise="none")
    assert isinstance(world, DartWorld)
    state = world.state()
    state["bodies"]["bodies"][0][0][5] = 3.0
    world.restore(state)
    with pytest.raises(SimulationError, match="the run ends"):
        world.step()


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


def test_only_the_shapes_near_a_body_are_in_the_physics() -> None:
    from tolman.world.physics.dart import DartWorld

    boxes = tuple(Box(0.4 * i, 0.4 * j, 0.1, 0.1) for i in range(30) for j in range(30))
    world = open_world(WorldSpec("many", boxes), noise="none", start=Pose(0.2, 0.11, 0.0))
    assert isinstance(world, DartWorld)
    seen: set[int] = set()
    for _ in range(400):
        world.robots[0].act(WheelCommand(800, 800))
        world.step()
        assert len(world.broad_phase.kept) <= 2
        seen.update(world.broad_phase.kept)
    assert len(seen) > 2
    assert world.true_pose().x > 1.0


def test_importing_the_package_loads_no_engine() -> None:
    code = (
        "import sys, tolman.world as world; world.open_world('env1', engine='kinematic').step(); "
        "print(sorted({'dartpy', 'embreex', 'matplotlib'} & set(sys.modules)))"
    )
    bare = (
        "import sys, tolman.world; "
        "print(sorted({'dartpy', 'embreex', 'matplotlib', 'yaml'} & set(sys.modules)))"
    )
    for program in (code, bare):
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        assert result.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("problem", "hint"),
    [
        ("libGL.so.1: cannot open shared object file: No such file or directory", "apt-get install libgl1"),
        ("libX11.so.6: cannot open shared object file", "apt-get install libx11-6"),
        ("No module named 'dartpy'", "pip install"),
        ("something else", "something else"),
    ],
)
def test_an_engine_that_cannot_be_loaded_says_what_to_install(problem: str, hint: str) -> None:
    from tolman.world.physics._dart import explain

    assert hint in explain(problem)
    assert "\n" not in explain(problem)
