"""The simulated e-puck2 as its protocol sees it."""

import math
from collections.abc import Iterator

import pytest
from tolman.world import Pose, World, open_world
from tolman.world.link.device import Device
from tolman.world.link.packets import CALIBRATE, PRESET, Command, unpack_image, wrapped
from tolman.world.link.units import E_PUCK2, Specimen, drawn_specimen
from tolman.world.spec import WorldSpec, room_walls

SQUARE = WorldSpec("square", room_walls(1.0, 1.0))


@pytest.fixture
def world() -> Iterator[World]:
    with open_world(
        SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=Pose(0.5, 0.5, 0.0)
    ) as opened:
        yield opened


def drive(device: Device, left: int, right: int, ticks: int) -> None:
    device.obey(Command(left=left, right=right))
    for _ in range(ticks):
        device.tick()


def test_a_robot_at_rest_is_flat_quiet_and_powered(world: World) -> None:
    sensors = Device(world).sensors()
    assert sensors.acceleration_vector == (0, 0, 768)
    assert sensors.acceleration == pytest.approx(768)
    assert (sensors.inclination, sensors.orientation) == (0.0, 0.0)
    assert sensors.gyro == (0, 0, 0)
    assert sensors.microphones == (0, 0, 0, 0)
    assert 2900 < sensors.battery < 3440
    assert sensors.selector == 15


def test_steps_are_counted_and_wrap(world: World) -> None:
    device = Device(world)
    device.obey(Command(settings=PRESET, left=32760, right=500))
    assert device.sensors().steps == (32760, 500)
    drive(device, 500, -500, 1)
    assert device.sensors().steps == (wrapped(32760 + 16), 484)


def test_speeds_are_clipped_as_the_robot_clips_them(world: World) -> None:
    device = Device(world)
    drive(device, 5000, 5000, 10)
    assert device.sensors().steps == (352, 352)


def test_a_left_turn_is_positive_for_the_gyro(world: World) -> None:
    device = Device(world)
    drive(device, -200, 200, 3)
    rate = device.sensors().gyro[2] / 131.0
    assert rate == pytest.approx(math.degrees(400 * E_PUCK2.radians_per_step), rel=0.01)


def test_what_is_near_shows_in_proximity_ambient_and_range(world: World) -> None:
    device = Device(world)
    far = device.sensors()
    world.place(Pose(0.5, 0.06, -math.pi / 2))
    for _ in range(6):
        device.tick()
    near = device.sensors()
    assert near.proximity[0] > far.proximity[0] + 100
    assert near.ambient[0] < far.ambient[0]
    assert near.tof < 60 < far.tof


def test_calibration_takes_the_baseline_of_a_specimen(world: World) -> None:
    device = Device(world, Specimen(offsets=(15.0,) * 8))
    assert min(device.sensors().proximity) >= 15
    device.obey(Command(settings=CALIBRATE))
    assert max(device.sensors().proximity) <= 1
    assert world.time == pytest.approx(1.024)


def test_specimens_follow_from_their_seed() -> None:
    assert drawn_specimen(3) == drawn_specimen(3) != drawn_specimen(4)


def test_images_are_the_cameras(world: World) -> None:
    device = Device(world)
    image = unpack_image(device.image())
    assert image.shape == (120, 160, 3)
    assert image.std() > 5
