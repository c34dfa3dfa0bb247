"""Each setting of each behavior is set, and seen to act; also through the behaviors that drive by another."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Any

import pytest
from tolman.agent import Agent
from tolman.agent.goals import FollowFrom, Foray, GoAlong, Leg
from tolman.behaviors.go_to_node import GoToNode
from tolman.behaviors.position_correction import PositionCorrection
from tolman.behaviors.wall_following import WallFollowing
from tolman.plugins import load_behaviors
from tolman.plugins.check import percepts
from tolman.plugins.testing import ScriptedRobot, Trial, percept
from tolman.world.robot import Percept

BUILT_IN = load_behaviors()
SETTINGS = [
    (name, each.name)
    for name, cls in sorted(BUILT_IN.items())
    if cls.__module__.startswith("tolman.behaviors.")
    for each in fields(cls.Config)
]
GOALS: dict[str, Any] = {
    "foray": Foray(turn=0.5),
    "go-to-node": GoAlong((Leg(0, 1, "right", 0.3, "concave", 0.5, FollowFrom.WALL),), face=1.0),
}
NEED_A_WORLD = {
    "dock": {"margin"},
    "foray": {"heading_gain", "leave"},
    "free-itself": {each.name for each in fields(BUILT_IN["free-itself"].Config)},
    "local-exploration": {
        "position_interval",
        "margin",
        "stop_margin",
        "touch_margin",
        "approach",
        "compass",
        "compass_views",
        "compass_range",
    },
    "local-go-to": {"fix_speed"},
    "look-around": {"tolerance"},
    "obstacle-avoidance": {"diagonal"},
    "position-correction": {"turn_speed"},
    "reactive-wall-following": {"rear_offset"},
    "wall-following": {"intrusion"},
}
"""What no scene below shows: it acts on a robot that is stuck or slips, on views, or at a certain corner."""


@cache
def scenes() -> tuple[list[Percept], ...]:
    """What is sensed: walls that come and go, a wall that stays at the side, one ahead, a wall that ends."""
    along, ahead = percept(right=0.022), percept(right=0.022, front=0.02)
    return (
        percepts(400),
        [along] * 200 + [ahead] * 60 + [along] * 100 + [percept()] * 300,
        [percept()] * 900,
        [percept(front=0.03)] * 300,
        [percept(right=0.03)] * 200 + [percept(right=0.04, front=0.1)] * 100 + [percept(right=0.008)] * 60,
    )


def traces(name: str, **settings: Any) -> list[Any]:
    """Proposals, states and events in each scene."""
    found = []
    for scene in scenes():
        trial = Trial(BUILT_IN[name](**settings), goal=GOALS.get(name, BUILT_IN[name].example))
        trial.run(scene)
        found.append((list(trial.proposals), list(trial.states), repr(trial.events)))
    return found


@cache
def default_traces(name: str) -> list[Any]:
    return traces(name)


def others(value: Any) -> list[Any]:
    """Values of the same type that are well below and above this one."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 2, max(1, value // 3)]
    return [0.3 * value, 3.0 * value] if value else [0.04]


@pytest.mark.parametrize(("name", "setting"), SETTINGS)
def test_a_setting_that_is_changed_acts(name: str, setting: str) -> None:
    if setting in NEED_A_WORLD.get(name, ()):
        pytest.skip("acts only in a world that the scenes do not have; see its own tests")
    default = getattr(BUILT_IN[name]().config, setting)
    assert any(traces(name, **{setting: value}) != default_traces(name) for value in others(default))


@pytest.mark.parametrize("parent", [GoToNode, PositionCorrection])
@pytest.mark.parametrize("setting", [each.name for each in fields(WallFollowing.Config)])
def test_a_setting_reaches_the_behaviors_that_drive_by_it(parent: type[Any], setting: str) -> None:
    value = others(getattr(WallFollowing().config, setting))[0]
    driving: Any = parent()
    Agent(ScriptedRobot(), [driving, WallFollowing(**{setting: value})])
    insisted = getattr(parent.children["follower"], "settings", {})
    assert getattr(driving.follower.config, setting) == insisted.get(setting, value)


def test_the_wall_distance_acts_through_go_to_node() -> None:
    def driven(**settings: Any) -> list[Any]:
        robot = ScriptedRobot([percept(right=0.03)])
        agent = Agent(robot, [GoToNode(), WallFollowing(**settings)])
        agent.start("go-to-node", GoToNode.example)
        for _ in range(60):
            agent.tick()
        return robot.commands

    assert driven(distance=0.07) != driven()


def test_without_a_behavior_of_its_own_the_child_has_the_defaults() -> None:
    driving = GoToNode()
    Agent(ScriptedRobot(), [driving])
    assert driving.follower.config == WallFollowing.Config()
