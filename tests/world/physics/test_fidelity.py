from __future__ import annotations

import math

import numpy as np
import pytest
from tolman.world import CONTROL_PERIOD, EPUCK, Pose, WheelCommand, WorldSpec, open_world
from tolman.world.physics.kinematic import drive
from tolman.world.physics.simulated import SimulatedWorld
from tolman.world.robot import wrap_angle
from tolman.world.spec import Box, MovableBox, Start, room_walls

MODELS = ("wheels", "planar")
BOX = MovableBox(Box(1.1, 1.0, 0.06, 0.10), 0.02, 0.2)
OPEN = WorldSpec("open", room_walls(6.0, 6.0), starts=(Start("middle", Pose(3.0, 3.0, 0.0)),))


def opened(spec: WorldSpec, model: str, start: Pose | None = None) -> SimulatedWorld:
    world = open_world(spec, noise="none", model=model, start=start)
    assert isinstance(world, SimulatedWorld)
    return world


def run(world: SimulatedWorld, left: float, right: float, ticks: int, robot: int = 0) -> Pose:
    for _ in range(ticks):
        world.robots[robot].act(WheelCommand(left, right))
        world.step()
    return world.true_pose(robot)


def ideal(start: Pose, left: float, right: float, ticks: int) -> Pose:
    scale = math.tau / EPUCK.steps_per_turn
    return drive(start, left * scale, right * scale, EPUCK.wheel_radius, EPUCK.track, ticks * CONTROL_PERIOD)


@pytest.mark.parametrize("model", MODELS)
def test_a_straight_meter_is_off_by_less_than_a_tenth_of_a_millimeter(model: str) -> None:
    world = opened(OPEN, model)
    start = world.true_pose()
    ticks = round(1.0 / (500 * EPUCK.distance_per_step * CONTROL_PERIOD))
    end, wanted = run(world, 500, 500, ticks), ideal(start, 500, 500, ticks)
    assert end.distance_to(wanted) < 0.1e-3
    assert abs(end.heading) < 1e-4


@pytest.mark.parametrize("model", MODELS)
def test_ten_turns_in_place_are_off_by_less_than_a_thousandth_of_a_degree(model: str) -> None:
    world = opened(OPEN, model)
    start = world.true_pose()
    ticks = round(10 * math.tau / (600 * EPUCK.radians_per_step * CONTROL_PERIOD))
    end, wanted = run(world, -300, 300, ticks), ideal(start, -300, 300, ticks)
    assert math.degrees(abs(wrap_angle(end.heading - wanted.heading))) < 1e-3
    assert end.distance_to(start) < 1e-4


@pytest.mark.parametrize("model", MODELS)
def test_an_arc_follows_the_circle(model: str) -> None:
    world = opened(OPEN, model)
    start = world.true_pose()
    end, wanted = run(world, 300, 400, 400), ideal(start, 300, 400, 400)
    # physics goes in the direction of the end of each step of 8 ms: off by the way driven in one, once
    assert end.distance_to(wanted) < 0.4e-3
    assert abs(wrap_angle(end.heading - wanted.heading)) < 1e-5


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("speeds", [(231, 235), (300, 400), (-99, 101), (200, 220)])
def test_a_robot_just_placed_has_grip_from_the_first_step_on(model: str, speeds: tuple[int, int]) -> None:
    world = opened(OPEN, model)
    world.place(Pose(2.0, 3.0, 0.3))
    end, wanted = run(world, *speeds, 10), ideal(Pose(2.0, 3.0, 0.3), *speeds, 10)
    assert math.degrees(abs(wrap_angle(end.heading - wanted.heading))) < 1e-3
    assert end.distance_to(wanted) < 0.4e-3


@pytest.mark.parametrize("model", MODELS)
def test_a_robot_stops_at_a_wall_and_its_encoders_go_on(model: str) -> None:
    world = opened(OPEN, model, Pose(5.9, 3.0, 0.0))
    end = run(world, 500, 500, 150)
    assert end.x == pytest.approx(6.0 - EPUCK.body_radius, abs=0.75e-3)
    assert abs(end.heading) < 0.02
    left, _ = world.robots[0].sense().encoders
    assert left == pytest.approx(150 * 500 * CONTROL_PERIOD)
    assert world.collisions() > 100


@pytest.mark.parametrize("model", MODELS)
def test_a_robot_slides_along_a_wall_that_it_meets_at_a_slant(model: str) -> None:
    world = opened(OPEN, model, Pose(3.0, 5.95, math.radians(20)))
    end = run(world, 500, 500, 100)
    assert end.y <= 6.0 - EPUCK.body_radius + 0.75e-3
    assert end.x > 3.08


@pytest.mark.parametrize("model", MODELS)
def test_nothing_drives_through_walls_whatever_the_commands(model: str) -> None:
    world = opened(WorldSpec("box", room_walls(0.3, 0.3)), model, Pose(0.15, 0.15, 0.3))
    random = np.random.default_rng(5)
    for _ in range(40):
        left, right = random.uniform(-1000, 1000, 2).tolist()
        pose = run(world, left, right, 15)
        assert world.clearance(pose.x, pose.y) > EPUCK.body_radius - 0.75e-3


@pytest.mark.parametrize("model", MODELS)
def test_one_robot_pushes_another(model: str) -> None:
    spec = WorldSpec("two", room_walls(2.0, 2.0), robots=(Pose(1.12, 1.0, math.pi / 2),))
    world = opened(spec, model, Pose(1.0, 1.0, 0.0))
    run(world, 600, 600, 80)
    gap = world.true_pose(0).distance_to(world.true_pose(1))
    assert gap > 2 * EPUCK.body_radius - 1e-3
    assert world.collisions(1) > 0
    if model == "wheels":
        assert world.true_pose(0).x < 1.15  # tires at right angles resist as much as the pusher's push


@pytest.mark.parametrize("model", MODELS)
def test_a_light_box_is_pushed_along(model: str) -> None:
    spec = WorldSpec(
        "push", room_walls(2.0, 2.0), movable=(MovableBox(Box(1.1, 1.0, 0.06, 0.10), 0.02, 0.2),)
    )
    world = opened(spec, model, Pose(1.0, 1.0, 0.0))
    run(world, 400, 400, 100)
    assert world.surroundings.boxes[0].x > 1.2
    assert max(world.robots[0].sense().infrared) > 1000


@pytest.mark.parametrize("model", MODELS)
def test_the_kinematic_twin_agrees_with_dart_where_nothing_is_touched(model: str) -> None:
    dart = opened(OPEN, model)
    twin = open_world(OPEN, noise="thesis", engine="kinematic", seed=3)
    real = open_world(OPEN, noise="thesis", model=model, seed=3)
    random = np.random.default_rng(2)
    for _ in range(30):
        left, right = random.uniform(-400, 400, 2).tolist()
        for _ in range(10):
            for world in (twin, real):
                world.robots[0].act(WheelCommand(left, right))
                world.step()
    assert twin.robots[0].sense().encoders == real.robots[0].sense().encoders
    assert twin.true_pose().distance_to(real.true_pose()) < 8e-3
    dart.close()


def test_the_wrong_track_turns_less() -> None:
    wide = open_world(OPEN, noise={"wrong_track": 0.1}, engine="kinematic")
    for _ in range(10):
        wide.robots[0].act(WheelCommand(-100, 100))
        wide.step()
    wanted = ideal(Pose(3.0, 3.0, 0.0), -100, 100, 10).heading / 1.1
    assert wide.true_pose().heading == pytest.approx(wanted)
