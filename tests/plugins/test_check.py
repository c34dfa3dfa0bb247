from __future__ import annotations

import random
import subprocess
import sys
import time
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import pytest
from tolman.agent import Behavior, Context, Proposal, Transition
from tolman.agent.events import Lost
from tolman.plugins import load_behaviors
from tolman.plugins.check import check_behavior
from tolman.world.robot import Percept, WheelCommand

BUILT_IN = load_behaviors()


class Good(Behavior):
    """Drives ahead."""

    class States(Enum):
        """ON: the only one."""

        ON = "on"

    name = "good"
    priority = 1
    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        return Proposal(WheelCommand(100.0, 100.0), reason="ahead")


class NotFinite(Good):
    """Divides by a sensor."""

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        return Proposal(WheelCommand(float("nan"), 1.0), reason="x")


class Forgetful(Good):
    """Keeps a count that `reset` does not reset."""

    count = 0

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        self.count += 1
        return Proposal(WheelCommand(self.count % 500, 0.0), reason="count")


class Dicing(Good):
    """Takes its randomness from elsewhere."""

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        return Proposal(WheelCommand(random.random(), 0.0), reason="dice")


class Slow(Good):
    """Dawdles."""

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        time.sleep(0.001)
        return None


class Flooding(Good):
    """Publishes without end."""

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        for _ in range(200):
            context.publish(Lost(time=context.time, reason="x"))
        return None


class Mute(Good):
    """Says nothing about why."""

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        return Proposal(WheelCommand(1.0, 1.0))


class Unreachable(Good):
    """Has a state nothing leads to."""

    class States(Enum):
        """ON, OFF."""

        ON = "on"
        OFF = "off"

    initial = States.ON  # type: ignore[assignment]
    transitions: ClassVar[tuple[Transition, ...]] = (Transition("on", States.OFF, States.ON),)

    def off(self, percept: Percept, context: Context) -> Proposal | None:
        """What it does."""
        return None


class Misnamed(Good):
    """Is called by a name no option can give."""

    name = "My Behavior"


class Undocumented(Good):
    pass


Undocumented.__doc__ = None


@pytest.mark.parametrize(
    ("cls", "check", "said"),
    [
        (NotFinite, "sane proposals", "not finite"),
        (Forgetful, "reset", "on_reset"),
        (Dicing, "determinism", "context.rng"),
        (Slow, "speed", "us (median)"),
        (Flooding, "limits", "events in one tick"),
        (Mute, "sane proposals", "no reason"),
        (Unreachable, "states", "no transition leads to OFF"),
        (Misnamed, "declarations", "lower case"),
        (Undocumented, "documentation", "no docstring"),
    ],
)
def test_each_kind_of_fault_is_found_and_what_to_fix_is_said(
    cls: type[Behavior], check: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tolman.plugins.check._no_simulator", lambda cls: iter(()))
    report = check_behavior(cls, ticks=100)
    failed = {finding.check: finding.fix for finding in report.findings if not finding.passed}
    assert said in failed.get(check, f"passed; failed: {failed}")
    assert not report.passed
    assert f"FIX  {check}" in report.text()


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_a_built_in_behavior_conforms(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tolman.plugins.check.SLOW", 1.0)  # no verdict by the clock of a busy machine
    monkeypatch.setattr("tolman.plugins.check._no_simulator", lambda cls: iter(()))
    report = check_behavior(BUILT_IN[name], ticks=150)
    assert report.passed, report.text()


def test_no_built_in_behavior_loads_a_simulator() -> None:
    code = (
        "import sys\nfrom tolman.plugins import load_behaviors\nload_behaviors()\n"
        "print([m for m in ('dartpy', 'embreex', 'matplotlib', 'yaml') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_goal_that_is_refused_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True)
    class Number:
        """value: must be 7."""

        value: int = 0

    class Wanting(Good):
        """Wants a goal."""

        Goal = Number

        def on_start(self, context: Context) -> None:
            if self.goal.value != 7:
                raise ValueError("the goal must be 7")

    monkeypatch.setattr("tolman.plugins.check._no_simulator", lambda cls: iter(()))
    assert not check_behavior(Wanting, ticks=10).passed
    assert check_behavior(Wanting, Number(7), ticks=10).passed
