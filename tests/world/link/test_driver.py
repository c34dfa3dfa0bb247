"""Our side of the link, over modelled links: odometry, stalls, images, and the end of a run."""

import math
from pathlib import Path

import numpy as np
import pytest
from tolman.world import Pose, WheelCommand, open_world
from tolman.world.errors import PlacementError, WorldError
from tolman.world.link.calibrating import measure_by_wall, measure_offsets
from tolman.world.link.calibration import Calibration, load_calibration
from tolman.world.link.channel import ModelChannel
from tolman.world.link.device import Device
from tolman.world.link.driver import LinkedRobot, LinkedWorld, resized
from tolman.world.link.model import Link, find_timings
from tolman.world.link.opening import behind_link
from tolman.world.link.packets import wrapped
from tolman.world.link.prediction import Predictor
from tolman.world.link.units import E_PUCK2, Specimen
from tolman.world.spec import WorldSpec, room_walls

SQUARE = WorldSpec("square", room_walls(1.0, 1.0))
MIDDLE, BY_THE_WALL = Pose(0.5, 0.5, 0.0), Pose(0.5, 0.055, 0.0)


def opened(link: str, seed: int = 0) -> LinkedWorld:
    world = open_world(SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=MIDDLE)
    return behind_link(world, link, seed)


def turn(world: LinkedWorld, angle: float) -> None:
    """Turns as behaviors do: by what the encoders say, one tick at a time, at most 200 steps/s."""
    robot, scale = world.robots[0], E_PUCK2.radians_per_step
    target = robot.sense().encoders[1] - robot.sense().encoders[0] + angle / scale
    for _ in range(400):
        left, right = robot.sense().encoders
        rest = target - (right - left)
        speed = max(-200.0, min(200.0, rest / (2 * 0.032)))
        robot.act(WheelCommand(-speed, speed))
        world.step()
        if abs(rest) < 1.5:
            break
    robot.act(WheelCommand(0.0, 0.0))
    for _ in range(12):
        world.step()


@pytest.mark.parametrize("link", ["ideal", "calm", "published"])
def test_turns_end_where_they_should_though_commands_come_late(link: str) -> None:
    with opened(link) as world:
        turn(world, 0.3)  # lets it learn the delay
        before = world.true_pose().heading
        turn(world, math.pi / 2)
        assert math.degrees(abs(world.true_pose().heading - before - math.pi / 2)) < 3.0


def test_encoders_come_to_what_was_truly_counted_after_stalls() -> None:
    with opened("published", 2) as world:
        robot = world.robots[0]
        for tick in range(600):
            speed = 120.0 if tick // 30 % 2 else -120.0
            robot.act(WheelCommand(speed, speed / 2))
            world.step()
        robot.act(WheelCommand(0.0, 0.0))
        for _ in range(80):
            world.step()
        assert isinstance(robot, LinkedRobot)
        assert robot.sense().encoders == pytest.approx(robot.predictor.counts, abs=1.0)
        assert robot.stalls > 0


def test_counts_that_begin_anew_are_no_motion() -> None:
    with opened("ideal") as world:
        robot = world.robots[0]
        assert isinstance(robot, LinkedRobot)
        before = robot.sense().encoders
        robot._counts = (wrapped(robot._counts[0] + 20000), 7) if robot._counts else None
        world.step()
        assert robot.sense().encoders == pytest.approx(before, abs=1.0)


def test_a_run_ends_with_wheels_that_stand_still() -> None:
    inner = open_world(SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=MIDDLE)
    world = behind_link(inner, "published", 3)
    world.robots[0].act(WheelCommand(300.0, 300.0))
    for _ in range(20):
        world.step()
    poses: list[Pose] = []
    inner.close, close = (lambda: poses.append(inner.true_pose())), inner.close  # type: ignore[method-assign]
    world.close()
    command = inner.robots[0].state()["command"]  # type: ignore[attr-defined]
    close()
    assert poses
    assert command == [0.0, 0.0]
    with pytest.raises(WorldError, match="closed"):
        world.step()


def test_an_image_is_the_cameras_own() -> None:
    with opened("calm") as world:
        image = world.robots[0].look()
        color = world.robots[0].look(160, 120, color=True)
    with open_world(SQUARE, engine="kinematic", noise="none", start=MIDDLE) as direct:
        same = direct.robots[0].look()
    assert image.shape == (16, 16)
    assert color.shape == (120, 160, 3)
    assert np.abs(image[3:13] - same[3:13]).mean() < 0.05


def test_images_are_resized_by_means() -> None:
    image = np.zeros((120, 160, 3), dtype=np.float32)
    image[:, :80] = 1.0
    assert resized(image, 2, 1, False).tolist() == [[pytest.approx(1.0), pytest.approx(0.0)]]
    assert resized(image, 160, 120, True) == pytest.approx(image)


def test_a_robot_behind_a_link_is_not_placed_nor_put_back() -> None:
    with opened("ideal") as world:
        with pytest.raises(PlacementError, match="carry"):
            world.place(Pose())
        with pytest.raises(WorldError, match="put back"):
            world.restore(world.state())


def test_the_predictor_learns_a_delay_and_sees_ahead_by_it() -> None:
    predictor, delay, counted = Predictor(), 0.096, 0.0
    speeds = [100.0 if tick // 10 % 2 else -60.0 for tick in range(200)]
    for tick, speed in enumerate(speeds):
        time = tick * 0.032
        predictor.counted(time, counted, 0.0)
        predictor.sent(time, speed, 0.0)
        counted += 0.032 * speeds[max(0, tick - 3)]
    assert predictor.delay == pytest.approx(delay, abs=0.02)
    coming = counted - 0.032 * speeds[196] + 0.032 * sum(speeds[196:199])
    assert predictor.now(199 * 0.032)[0] == pytest.approx(coming, abs=2.0)


def specimen_world(specimen: Specimen, start: Pose, wrong_track: float) -> LinkedWorld:
    noise = {"wrong_track": wrong_track}
    world = open_world(SQUARE, engine="kinematic", noise=noise, geometry=E_PUCK2, start=start)
    channel = ModelChannel(Link(Device(world, specimen), find_timings("ideal"), 0))
    return LinkedWorld(LinkedRobot(channel, E_PUCK2), world.spec, 0, world)


def test_calibration_finds_offsets_gains_and_track(tmp_path: Path) -> None:
    gains = (1.2, 0.8, 1.0, 0.9, 1.1, 1.0, 1.15, 0.85)
    specimen = Specimen(gains, tuple(float(3 * each) for each in range(8)))
    with specimen_world(specimen, MIDDLE, 0.0) as world:
        resting = measure_offsets(world, Calibration())
    assert resting.offsets == pytest.approx(
        [10 * gain + offset - 10 for gain, offset in zip(gains, specimen.offsets, strict=True)], abs=0.6
    )
    with specimen_world(specimen, BY_THE_WALL, 0.06) as world:
        found = measure_by_wall(world, resting)
    assert found.gains == pytest.approx(gains, rel=0.06)
    assert found.track == pytest.approx(1.06, abs=0.005)


def test_a_baseline_is_not_taken_by_a_wall() -> None:
    with (
        specimen_world(Specimen(), BY_THE_WALL, 0.0) as world,
        pytest.raises(WorldError, match="near"),
    ):
        measure_offsets(world, Calibration())


def test_a_calibration_is_read_as_it_was_written(tmp_path: Path) -> None:

    path = tmp_path / "c.yaml"
    kept = Calibration((1.25,) * 8, (3.5,) * 8, 1.01)
    kept.save(path)
    assert load_calibration(path) == kept
    assert kept.geometry(E_PUCK2).track == pytest.approx(0.053 * 1.01)
    assert kept.freed((103.5,) * 8) == pytest.approx((80.0,) * 8)
    path.write_text("gains: [1, 2]\n")
    with pytest.raises(WorldError, match=r"c\.yaml.*1.*gains"):
        load_calibration(path)
    path.write_text("trak: 1\n")
    with pytest.raises(WorldError, match="track"):
        load_calibration(path)
