from __future__ import annotations

import math

import pytest
from tolman.agent.perception.side_view import WallCourse
from tolman.agent.perception.wall_filter import SideWall

STEP = 0.00096


def followed(distance: float = 0.057, lines: int = 40) -> SideWall:
    wall = SideWall(distance)
    for _ in range(lines):
        wall.predict(STEP, 0.0)
        wall.see((distance, 0.0), distance, ahead=False)
    return wall


def test_a_wall_that_bends_away_or_nearer_is_followed_in_its_new_direction() -> None:
    for bend in (math.radians(25.0), math.radians(-25.0)):
        wall = followed()
        distance = 0.057
        for tick in range(60):
            wall.predict(STEP, 0.0)
            distance += STEP * math.sin(bend) if tick > 10 else 0.0
            wall.see((distance, bend), distance / math.cos(bend), ahead=False)
        assert wall.angle == pytest.approx(bend, abs=0.03)
        assert wall.distance == pytest.approx(distance, abs=0.002)


def test_a_step_in_the_wall_changes_its_distance_and_not_its_direction() -> None:
    wall = followed()
    for _ in range(30):
        wall.predict(STEP, 0.0)
        wall.see((0.042, 0.0), 0.042, ahead=False)
    assert wall.distance == pytest.approx(0.042, abs=0.001)
    assert wall.angle == pytest.approx(0.0, abs=0.02)


def test_what_the_diagonal_sensor_alone_sees_ahead_turns_nothing() -> None:
    """Near a blunt corner its hit lies on the next wall: the line through both is no wall."""
    wall = followed()
    for tick in range(12):
        wall.predict(STEP, 0.0)
        wall.see((0.057, -0.01 * tick), 0.057, ahead=True)
    assert abs(wall.angle) < 0.008


def test_one_odd_line_changes_nothing() -> None:
    wall = followed()
    wall.see((0.03, 0.6), 0.057, ahead=False)
    wall.see((0.057, 0.0), 0.057, ahead=False)
    assert (wall.distance, wall.angle) == pytest.approx((0.057, 0.0), abs=1e-3)


def test_a_course_tells_how_far_a_wall_has_turned_and_how_sharply() -> None:
    even, blunt = WallCourse(), WallCourse()
    for centimeter in range(100):
        even.take(0.01 * centimeter, 3.0 + 0.004 * centimeter)
        blunt.take(0.01 * centimeter, 0.4 if centimeter > 50 else 0.0)
    assert even.swing == pytest.approx(0.396)
    assert even.max_heading_change == pytest.approx(0.04)
    assert (blunt.swing, blunt.max_heading_change) == pytest.approx((0.4, 0.4))


def test_a_course_keeps_one_direction_a_centimeter() -> None:
    course = WallCourse()
    assert [course.take(path, 0.0) for path in (0.0, 0.004, 0.011, 0.015, 0.021)] == [
        *(True, False, True, False, True)
    ]
