from __future__ import annotations

import pytest
from tolman.world import Pose, SimulationError, WheelCommand, WorldSpec, open_world
from tolman.world.physics._dart import explain
from tolman.world.physics.dart import DartWorld
from tolman.world.spec import Box


def test_a_robot_that_tips_ends_the_run_with_an_error() -> None:
    world = open_world("env1", noise="none")
    assert isinstance(world, DartWorld)
    state = world.state()
    state["bodies"]["bodies"][0][0][0] = 1.2
    world.restore(state)
    with pytest.raises(SimulationError, match="tipped or flew off"):
        world.step()


def test_a_robot_that_is_nowhere_ends_the_run_with_an_error() -> None:
    world = open_world("env1", noise="none")
    assert isinstance(world, DartWorld)
    state = world.state()
    state["bodies"]["bodies"][0][0][5] = 3.0
    world.restore(state)
    with pytest.raises(SimulationError, match="the run ends"):
        world.step()


def test_only_the_shapes_near_a_body_are_in_the_physics() -> None:
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
    assert hint in explain(problem)
    assert "\n" not in explain(problem)
