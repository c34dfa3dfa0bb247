from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import tolman.agent
from tolman.agent import Agent, Behavior, ConfigError
from tolman.agent.events import (
    BehaviorFaulted,
    BehaviorFinished,
    Event,
    Lost,
    MediatorFaulted,
    PluginEvent,
)
from tolman.agent.handle import Limits
from tolman.behaviors.wander import Wander
from tolman.plugins import build_behaviors, discover, load_mediator
from tolman.plugins.isolation.proxy import IsolatedBehavior, close_all
from tolman.plugins.testing import ScriptedRobot, Trial, event_of, percept

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

SOURCE = '''
import ctypes, os, sys, time
from dataclasses import dataclass
from enum import Enum
from tolman.agent import Behavior, Proposal, Transition
from tolman.agent.events import Lost, PluginEvent
from tolman.world.robot import WheelCommand

@dataclass(frozen=True, slots=True)
class Settings:
    """speed: steps/s. misdeed: what it does in tick 3."""
    speed: float = 100.0
    misdeed: str = ""

@dataclass(frozen=True, slots=True)
class Visit:
    """end: whether it finishes in tick 5."""
    end: bool = False

class Guest(Behavior):
    """Drives ahead, and says what it is told to."""
    class States(Enum):
        FIRST = 1
        LATER = 2
    name = "guest"
    priority = 30
    initial = States.FIRST
    transitions = (Transition("go", States.FIRST, States.LATER),)
    Config = Settings
    Goal = Visit
    def on_reset(self):
        self.ticks = 0
        self.heard = 0
    def on_start(self, context):
        context.subscribe(Lost, self.hear)
    def hear(self, event):
        self.heard += 1
    def later(self, percept, context):
        return self.first(percept, context)
    def first(self, percept, context):
        self.ticks += 1
        if self.ticks == 2:
            self.fire("go")
        if self.ticks == 3:
            self.misbehave(context)
        if self.ticks == 5 and self.goal.end:
            self.finish(True, "enough", result=(self.heard, self.ticks))
            return None
        return Proposal(WheelCommand(self.config.speed, percept.infrared[2]), 0.5, f"tick {self.ticks}")
    def misbehave(self, context):
        misdeed = self.config.misdeed
        if misdeed == "raise": raise RuntimeError("on purpose")
        if misdeed == "exit": os._exit(7)
        if misdeed == "segfault": ctypes.string_at(0)
        if misdeed == "hang":
            while True: pass
        if misdeed == "leak":
            self.kept = bytearray(1 << 33)
        if misdeed == "look":
            data = {"sum": float(context.look().sum())}
            context.publish(PluginEvent(time=context.time, name="seen", data=data))
'''


MEDIATOR = """
import os
from tolman.agent.arbitration.mediator import Decision
from tolman.world.robot import WheelCommand

class Last:
    '''Takes the last.'''
    name = "last"
    ticks = 0
    def arbitrate(self, candidates, previous):
        self.ticks += 1
        if self.ticks == 3:
            os._exit(5)
        return Decision(candidates[-1].name, WheelCommand(77.0, 77.0), "last")
    def reset(self): ...
"""
NAMES = ["guest", "friend", "other"]
Make = Callable[..., Behavior]


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine makes no faults."""
    monkeypatch.setattr("tolman.plugins.isolation.proxy.ANSWER_TIMEOUT", 60.0)
    monkeypatch.setattr("tolman.plugins.isolation.process.START_TIMEOUT", 120.0)


@pytest.fixture
def guest(tmp_path: Path) -> Iterator[Make]:
    (tmp_path / "guest.py").write_text(SOURCE)
    made: list[Behavior] = []

    def build(**settings: object) -> Behavior:
        built = build_behaviors(["guest"], [tmp_path], {"guest": settings}, isolate=True)
        made.extend(built.values())
        return built["guest"]

    yield build
    close_all(made)


def run(behavior: Behavior, ticks: int, goal: object = None) -> tuple[Agent, ScriptedRobot, list[Event]]:
    robot, heard = ScriptedRobot([percept(right=0.02)]), list[Event]()
    agent = Agent(robot, [behavior, Wander()], limits=Limits(budget=None))
    agent.bus.subscribe(Event, heard.append)
    agent.start("guest", goal)
    agent.start("wander")
    for tick in range(ticks):
        if tick == 2:
            agent.bus.publish(Lost(time=0.0, reason="x"))
        agent.tick()
    return agent, robot, heard


def test_an_isolated_behavior_proposes_what_it_would_in_the_process(guest: Make, tmp_path: Path) -> None:
    here = build_behaviors(["guest"], [tmp_path])["guest"]
    trials = [Trial(behavior) for behavior in (guest(), here)]
    for trial in trials:
        trial.run([percept(right=0.01 * tick) for tick in range(6)])
    assert isinstance(trials[0].behavior, IsolatedBehavior)
    assert trials[0].proposals == trials[1].proposals
    assert [state.name for state in trials[0].states] == ["FIRST", "LATER"]


def test_it_hears_events_looks_publishes_and_finishes(guest: Make) -> None:
    _, _, heard = run(guest(misdeed="look"), 6, goal={"end": True})
    seen = event_of(heard, PluginEvent)
    assert seen.data["sum"] == pytest.approx(128.0)
    finished = event_of(heard, BehaviorFinished)
    assert (finished.succeeded, finished.reason, finished.result) == (True, "enough", (1, 5))


@pytest.mark.parametrize(
    ("misdeed", "said"),
    [
        ("raise", "RuntimeError: on purpose"),
        ("exit", "exit status 7"),
        ("segfault", "exit status -11"),
        ("hang", "did not answer in time"),
        ("leak", "MemoryError"),
    ],
)
def test_whatever_it_does_costs_one_tick_and_it_is_back(
    guest: Make, misdeed: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tolman.plugins.isolation.proxy.ANSWER_TIMEOUT", 2.0 if misdeed == "hang" else 60.0)
    agent, robot, heard = run(guest(misdeed=misdeed, speed=150.0), 5, goal={"end": False})
    fault = event_of(heard, BehaviorFaulted)
    assert said in fault.fault
    assert fault.state == "LATER"
    assert [command.left for command in robot.commands] == [150.0, 150.0, 0.0, 150.0, 150.0]
    assert agent.is_active("guest")


def test_a_file_that_kills_its_importer_kills_only_a_subprocess(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text("import os\nos._exit(9)\n")
    catalog = discover([tmp_path], isolate=True)
    assert "exit status 9" in catalog.broken[str(tmp_path / "bad.py")]


def test_wrong_settings_are_refused_when_it_is_made(guest: Make) -> None:
    with pytest.raises(ConfigError, match="unknown setting 'sped'"):
        guest(sped=1.0)


def test_isolate_true_among_the_settings_isolates_that_ones_file_alone(tmp_path: Path) -> None:
    named = {name: SOURCE.replace("Guest", name.title()).replace('"guest"', f'"{name}"') for name in NAMES}
    (tmp_path / "guest.py").write_text(named["guest"] + named["friend"])
    (tmp_path / "other.py").write_text(named["other"])
    built = build_behaviors(NAMES, [tmp_path], {"guest": {"isolate": True}})
    assert isinstance(built["guest"], IsolatedBehavior)
    assert isinstance(built["friend"], IsolatedBehavior)
    assert not isinstance(built["other"], IsolatedBehavior)
    close_all(built.values())


def test_nothing_of_an_isolated_file_is_imported_here(tmp_path: Path) -> None:
    spoiling = "import tolman.maps.som, tolman.agent\ntolman.agent.spoiled = True\n"
    (tmp_path / "guest.py").write_text(spoiling + SOURCE + MEDIATOR)
    before = set(sys.modules)
    catalog = discover([tmp_path], isolate=True)
    built = build_behaviors(["guest"], catalog)
    mediator = load_mediator("last", catalog)
    cls = catalog.find("guest").load()
    assert (cls.__doc__, cls.priority) == ("Drives ahead, and says what it is told to. (isolated)", 30)
    assert not [name for name in set(sys.modules) - before if name.startswith("tolman_plugin_")]
    assert not hasattr(tolman.agent, "spoiled")
    close_all([*built.values(), mediator])


def test_a_mediator_of_an_isolated_file_decides_in_its_subprocess(tmp_path: Path) -> None:
    (tmp_path / "odd.py").write_text("import os\n" + MEDIATOR)
    mediator = load_mediator("last", [tmp_path], isolate=True)
    robot, heard = ScriptedRobot(), list[Event]()
    agent = Agent(robot, [Wander()], mediator=mediator)
    agent.bus.subscribe(Event, heard.append)
    agent.start("wander")
    for _ in range(3):
        agent.tick()
    assert agent.driver == "wander"
    assert [command.left for command in robot.commands] == [77.0, 77.0, 0.0]
    assert "exit status 5" in event_of(heard, MediatorFaulted).fault
    close_all([mediator])


def test_no_process_is_left_when_it_is_closed(guest: Make) -> None:
    behavior = guest()
    assert isinstance(behavior, IsolatedBehavior)
    assert behavior._child is not None
    process = behavior._child._process
    behavior.close()
    assert process.poll() is not None
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)
