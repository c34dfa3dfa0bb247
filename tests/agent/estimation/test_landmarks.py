from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from tolman.agent.estimation.landmarks import SHORT_SWEEP, LandmarkFix
from tolman.agent.estimation.local_filter import LocalPose
from tolman.plugins.testing import percept
from tolman.world.robot import CONTROL_PERIOD, EPUCK, Percept

Between = Callable[..., Percept]
NORMAL, DISTANCE = -0.5 * math.pi, 0.057
"""Of the wall on the right."""


def rock(fix: LandmarkFix, between: Between, askew: float, walls: list[tuple[float, float]]) -> float:
    """Turns to and fro, truly turned by `askew` (rad) more than it holds; how far it turned in all."""
    trial_turned = 0.0
    context = _Context()
    fix.begin(SHORT_SWEEP)
    for _ in range(2000):
        command = fix.fix(between(walls, fix.pose.heading + askew), context, 150.0)  # type: ignore[arg-type]
        if command is None:
            return trial_turned
        context.turn = (command.right - command.left) * EPUCK.radians_per_step * CONTROL_PERIOD
        trial_turned += abs(context.turn)
        fix.pose.move(0.0, context.turn)
    raise AssertionError("the turn to and fro does not end")


class _Context:
    geometry = EPUCK
    turn = 0.0


def unsure() -> LocalPose:
    pose = LocalPose()
    pose.know(NORMAL, DISTANCE, 0.005)
    for _ in range(20):
        pose.move(0.0, 0.5)
        pose.move(0.0, -0.5)
    return pose


@pytest.mark.parametrize("askew", [-0.08, 0.03, 0.1])
def test_turning_to_and_fro_beside_a_known_wall_tells_the_heading(between: Between, askew: float) -> None:
    pose = unsure()
    fix = LandmarkFix(EPUCK, pose)
    turned = rock(fix, between, askew, [(NORMAL, DISTANCE)])
    assert turned == pytest.approx(sum(map(abs, SHORT_SWEEP)), abs=0.1)
    assert fix.correct()
    assert pose.heading == pytest.approx(askew, abs=0.015)


def test_in_the_open_a_fix_changes_nothing(between: Between) -> None:
    pose = unsure()
    fix = LandmarkFix(EPUCK, pose)
    rock(fix, between, 0.1, [])
    assert not fix.correct()
    assert pose.heading == pytest.approx(0.0, abs=0.006)


def test_by_path_integration_alone_walls_do_not_count(between: Between) -> None:
    pose = unsure()
    fix = LandmarkFix(EPUCK, pose, landmarks=False)
    rock(fix, between, 0.1, [(NORMAL, DISTANCE)])
    assert not fix.correct()
    assert pose.heading == pytest.approx(0.0, abs=0.006)


def test_what_was_swept_over_elsewhere_is_forgotten(between: Between) -> None:
    pose = unsure()
    fix = LandmarkFix(EPUCK, pose)
    rock(fix, between, 0.1, [(NORMAL, DISTANCE)])
    fix.forget()
    assert not fix.correct()


@pytest.mark.parametrize("heading", [-2.5, -1.0, 0.2, 1.9])
def test_it_turns_a_sensor_to_the_wall_by_the_shortest_way(heading: float) -> None:
    pose = LocalPose(heading)
    pose.know(NORMAL, DISTANCE, 0.005)
    turn = LandmarkFix(EPUCK, pose).turn_to_see()
    facing = NORMAL - heading - turn
    assert min(abs(math.remainder(facing - a, math.tau)) for a in (0.0, *EPUCK.infrared_angles)) < 1e-9
    assert abs(turn) < math.radians(31.0)


def test_where_no_wall_can_be_seen_it_need_not_turn() -> None:
    pose = LocalPose()
    pose.know(NORMAL, DISTANCE, 0.005, (-0.087, 0.0))
    assert LandmarkFix(EPUCK, pose).turn_to_see() == 0.0


def test_what_stands_near_by_is_remembered_while_turning() -> None:
    fix = LandmarkFix(EPUCK, LocalPose())
    for _ in range(3):
        fix.sweep(percept(front=0.03))
    assert fix.memory.blocks((0.0, 0.0), (0.05, 0.0), 0.04)
