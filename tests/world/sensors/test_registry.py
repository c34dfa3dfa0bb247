from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from tolman.world import EPUCK, EPUCK2, Pose, WorldError, open_world
from tolman.world.sensors.registry import SENSORS, fitted

from ..arrangements import SQUARE


@pytest.mark.parametrize(
    ("sensing", "problem"),
    [
        ({"infrared": {"delay": 0.01}}, "0.01 s is not a multiple of the control period of 0.032"),
        ({"infrred": {"delay": 0.032}}, "did you mean 'infrared'"),
        ({"camera": {"dely": 0.032}}, "unknown camera setting 'dely'"),
        ({"camera": {"interval": 0.0}}, "outside"),
        ({"camera": {"delay": "soon"}}, "number of seconds"),
        ({"camera": 3}, "expected a mapping"),
    ],
)
def test_a_wrong_sensor_setting_is_explained(sensing: Any, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        open_world("env1", engine="kinematic", sensing=sensing)


def test_a_robot_carries_the_sensors_of_its_model_and_those_asked_for() -> None:
    assert "range" not in fitted(EPUCK)
    assert "range" in fitted(EPUCK2)
    assert "range" in fitted(EPUCK, {"range": {}})


def test_a_model_with_an_unknown_sensor_is_refused() -> None:
    with pytest.raises(WorldError, match="unknown sensor 'sonar'"):
        fitted(replace(EPUCK, extra_sensors=("sonar",)))


def test_another_timing_leaves_what_is_not_named() -> None:
    _, timing = fitted(EPUCK2, {"range": {"delay": 0.064}})["range"]
    assert (timing.delay, timing.interval) == (0.064, SENSORS["range"].timing.interval)


def test_what_other_sensors_measure_does_not_depend_on_which_more_there_are() -> None:
    def sensed(**options: Any) -> list[Any]:
        world = open_world(SQUARE, seed=3, engine="kinematic", start=Pose(1.9, 1.0, 0.0), **options)
        found = []
        for _ in range(100):
            world.step()
            percept = world.robots[0].sense()
            found.append((percept.infrared, percept.encoders, percept.accelerometer))
        return [*found, world.robots[0].look().tolist()]

    assert sensed() == sensed(sensing={"range": {}})
