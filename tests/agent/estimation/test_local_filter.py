from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.estimation.local_filter import LocalPose
from tolman.agent.perception.wall_scan import SeenWall
from tolman.world.robot import Pose, wrap_angle

RIGHT = -0.5 * math.pi


def seen(true: Pose, believed: LocalPose, normal: float, offset: float, deviation: float = 0.005) -> SeenWall:
    """The wall n . p = offset of the local frame, as it is seen from `true` by who trusts its own heading."""
    distance = offset - true.x * math.cos(normal) - true.y * math.sin(normal)
    return SeenWall(normal + believed.heading - true.heading, distance, deviation)


def unsure(pose: LocalPose) -> LocalPose:
    """The same place and heading, less well known: a way out and back."""
    for _ in range(100):
        pose.move(0.002, 0.0)
    for _ in range(100):
        pose.move(-0.002, 0.0)
    return pose


@given(st.floats(-0.08, 0.08), st.floats(-0.004, 0.004), st.floats(-0.004, 0.004))
def test_two_known_walls_correct_heading_and_place(error: float, dx: float, dy: float) -> None:
    true, pose = Pose(dx, dy, error), unsure(LocalPose())
    pose.know(RIGHT, 0.057, 0.005)
    pose.know(0.0, 0.057, 0.005)
    for _ in range(6):
        assert pose.see(seen(true, pose, RIGHT, 0.057))
        assert pose.see(seen(true, pose, 0.0, 0.057))
    assert pose.heading == pytest.approx(error, abs=0.1 * abs(error) + 1e-3)
    assert pose.x == pytest.approx(dx, abs=1.5e-3)
    assert pose.y == pytest.approx(dy, abs=1.5e-3)


def test_a_wall_met_while_the_pose_is_good_corrects_it_later() -> None:
    pose = LocalPose()
    assert not pose.see(seen(Pose(), pose, 1.0, 0.06))
    unsure(pose)
    true = Pose(0.0, 0.0, 0.05)
    assert pose.see(seen(true, pose, 1.0, 0.06))
    assert pose.heading == pytest.approx(0.05, abs=0.007)


def test_where_walls_are_square_a_new_one_tells_the_heading_at_once() -> None:
    true, square, free = Pose(0.0, 0.0, 0.04), unsure(LocalPose(square=True)), unsure(LocalPose())
    for pose in (square, free):
        assert not pose.see(seen(true, pose, 0.5 * math.pi, 0.06))
    assert square.heading == pytest.approx(0.04, abs=0.005)
    assert free.heading == pytest.approx(0.0, abs=1e-9)


def test_where_walls_are_square_a_slanted_one_is_not_kept() -> None:
    pose = LocalPose(square=True)
    assert not pose.see(SeenWall(math.radians(40.0), 0.06, 0.005))
    assert pose.landmarks == []
    assert pose.heading == 0.0


def test_a_correction_that_cannot_be_is_refused() -> None:
    pose = LocalPose()
    pose.turn_by_compass(0.5, 0.001**2)
    assert pose.heading == 0.0


def test_a_compass_corrects_the_heading_and_makes_it_surer() -> None:
    pose = unsure(LocalPose())
    before = pose.heading_variance
    pose.turn_by_compass(0.03, 0.005**2)
    assert pose.heading == pytest.approx(0.03, abs=0.003)
    assert pose.heading_variance < before


@given(st.lists(st.tuples(st.floats(-0.01, 0.01), st.floats(-0.1, 0.1)), max_size=30))
def test_without_walls_it_is_path_integration_and_grows_less_sure(moves: list[tuple[float, float]]) -> None:
    pose = LocalPose()
    x = y = heading = 0.0
    for distance, turn in moves:
        before = pose.heading_variance
        pose.move(distance, turn)
        x += distance * math.cos(heading + 0.5 * turn)
        y += distance * math.sin(heading + 0.5 * turn)
        heading += turn
        assert pose.heading_variance >= before
    assert (pose.x, pose.y, pose.heading) == pytest.approx((x, y, heading), abs=1e-9)


def test_the_errors_of_an_exploration_are_as_large_as_it_says() -> None:
    """Turns and short ways at random with the noise it expects, two walls swept now and then."""
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(150):
        pose, true = LocalPose(), Pose()
        pose.know(RIGHT, 0.057, 0.005)
        pose.know(0.0, 0.057, 0.005)
        for step in range(12):
            for way, turn in ((0.0, rng.uniform(-1.5, 1.5)), (0.02, 0.0)):
                slip = rng.normal(0.0, math.sqrt(pose.turn_noise**2 * abs(turn) + pose.drift**2 * way))
                true = true.compose(way, 0.0, turn + slip)
                pose.move(way, turn)
            if step % 3 == 2:
                for normal in (RIGHT, 0.0):
                    distance = 0.057 - true.x * math.cos(normal) - true.y * math.sin(normal)
                    tilt = pose.heading - true.heading + rng.normal(0.0, 0.008)
                    wall = SeenWall(normal + tilt, distance + rng.normal(0.0, 0.001), 0.008)
                    pose.see(wall)
        ratios.append(wrap_angle(pose.heading - true.heading) ** 2 / pose.heading_variance)
    assert 0.5 < float(np.mean(ratios)) < 1.7


@pytest.mark.parametrize("drift_rate", [0.35, -0.2])
def test_walls_tell_what_unequal_wheels_turn(drift_rate: float) -> None:
    """There and back, 5 cm each way and turned round between, by wheels that nothing is known of."""
    pose, true = LocalPose(drift_rate=0.23), Pose()
    pose.know(RIGHT, 0.057, 0.005)
    pose.know(0.0, 0.057, 0.005)
    for _ in range(30):
        for step, turn in [(0.002, 0.0)] * 25 + [(0.0, math.pi)]:
            pose.move(step, turn)
            true = true.compose(step, 0.0, turn + drift_rate * step)
        for normal in (RIGHT, 0.0):
            pose.see(seen(true, pose, normal, 0.057))
    assert pose.drift_rate == pytest.approx(drift_rate, abs=0.08)
    assert abs(wrap_angle(pose.heading - true.heading)) < 0.02


def test_where_a_wall_was_barely_seen_is_no_vantage_point() -> None:
    pose = LocalPose()
    pose.know(RIGHT, 0.057, 0.005, (0.1, 0.0))
    assert pose.see(seen(Pose(), pose, RIGHT, 0.057, deviation=0.02))
    assert pose.landmarks[0].vantage == (0.1, 0.0)
    assert pose.see(seen(Pose(), pose, RIGHT, 0.057, deviation=0.004))
    assert math.hypot(*pose.landmarks[0].vantage) < 0.01


def test_unequal_wheels_make_it_doubtful_sooner() -> None:
    known, unknown = LocalPose(), LocalPose(drift_rate=0.23)
    for pose in (known, unknown):
        for _ in range(200):
            pose.move(0.002, 0.0)
    assert unknown.doubtful
    assert not known.doubtful


def test_a_belief_is_all_there_is_to_a_pose() -> None:
    pose = unsure(LocalPose(0.3, square=True, drift_rate=0.1))
    pose.know(RIGHT, 0.057, 0.005, (-0.087, 0.0))
    pose.see(seen(Pose(0.0, 0.0, 0.3), pose, 0.0, 0.06))
    again = LocalPose.of(pose.belief())
    assert again.belief() == pose.belief()
    for each in (pose, again):
        each.move(0.02, 0.4)
        each.see(seen(Pose(0.02, 0.0, 0.7), each, RIGHT, 0.057))
    assert again.belief() == pose.belief()


def test_vantage_points_are_of_walls_in_two_directions_the_nearest_to_the_node_last() -> None:
    pose = LocalPose()
    for wall in (
        (RIGHT, 0.057, 0.005, (-0.087, 0.0)),
        (-RIGHT, 0.09, 0.005, (0.0, 0.04)),
        (0.0, 0.1, 0.005, (0.05, 0.05)),
    ):
        pose.know(*wall)
    assert [mark.vantage for mark in pose.vantage_points()] == [(0.05, 0.05), (0.0, 0.04)]


def test_a_pose_becomes_doubtful_by_turning_and_certain_by_a_wall() -> None:
    pose = LocalPose()
    pose.know(RIGHT, 0.057, 0.005)
    turned = 0
    while not pose.doubtful:
        pose.move(0.0, 1.0)
        turned += 1
    assert 20 < turned < 100
    pose.see(seen(Pose(0.0, 0.0, pose.heading), pose, RIGHT, 0.057))
    assert not pose.doubtful
