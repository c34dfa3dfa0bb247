"""The pytest plugin: the test kit as fixtures. Loaded by pytest wherever tolman is installed.

Everything is imported when a fixture is used: a test run that uses none pays nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from ...agent.behavior import Behavior
    from ...world.robot import Percept
    from ..trial import ScriptedRobot, Trial

pytest.register_assert_rewrite("tolman.plugins.testing.assertions")


@pytest.fixture
def percept() -> Callable[..., Percept]:
    """Percepts from words: `percept(right=0.02)` is a wall 2 cm on the right. See `testing.percept`."""
    from ..trial import percept as build

    return build


@pytest.fixture
def scripted_robot() -> Callable[..., ScriptedRobot]:
    """Robots that sense what a list says: `scripted_robot([percept(front=0.01)])`."""
    from ..trial import ScriptedRobot

    return ScriptedRobot


@pytest.fixture
def trial() -> Callable[..., Trial]:
    """Trials of one behavior alone: `trial(MyBehavior(), goal=...)`."""
    from ..trial import Trial

    return Trial


@pytest.fixture
def check_plugin() -> Callable[[type[Behavior]], None]:
    """Fails with what to fix unless the behavior class passes `tolman plugins check`."""
    from ..check import check_behavior

    def check(cls: type[Behavior]) -> None:
        report = check_behavior(cls)
        assert report.passed, report.text()

    return check


@pytest.fixture
def kinematic_world() -> Iterator[Callable[..., Any]]:
    """Worlds without a physics engine: `kinematic_world("env1", noise="none")`; closed after the test."""
    from ...world import open_world

    opened: list[Any] = []

    def build(world: str | Path = "env1", **options: Any) -> Any:
        opened.append(open_world(world, engine="kinematic", **options))
        return opened[-1]

    yield build
    for world in opened:
        world.close()


@pytest.fixture
def recorded_percepts() -> Callable[[Path], list[Percept]]:
    """The percepts of a recorded run, in order: `scripted_robot(recorded_percepts(path))`."""
    from ...agent.recording.reader import read_percepts

    return read_percepts
