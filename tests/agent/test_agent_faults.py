from __future__ import annotations

import contextlib
import logging
import math
import signal
import time
from collections.abc import Callable
from enum import Enum
from typing import Any, NoReturn

import pytest
from tolman.agent import Agent, AgentError, Behavior, Candidate, Context, Decision, Proposal
from tolman.agent.containment import Watchdog
from tolman.agent.events import (
    BehaviorFaulted,
    BehaviorFinished,
    BehaviorStarted,
    ControlChanged,
    Event,
    LoopClosed,
    Lost,
    MediatorFaulted,
    PluginEvent,
)
from tolman.agent.handle import Limits
from tolman.files.interrupts import UserInterrupt, raised
from tolman.plugins.testing import ScriptedRobot, assert_event_order, event_of
from tolman.world.robot import STOP, Percept, WheelCommand

UNTIMED = Limits(budget=None)
AHEAD = WheelCommand(100.0, 100.0)


class Steady(Behavior):
    class States(Enum):
        ON = "on"

    name = "steady"
    priority = 10
    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        return Proposal(AHEAD, reason="steady")


class Faulty(Steady):
    """Does once, in its third tick, what it was made with."""

    name = "faulty"
    priority = 20

    def __init__(self, misdeed: Callable[[Context], Any]) -> None:
        self.misdeed = misdeed
        super().__init__()

    def on_reset(self) -> None:
        self.ticks = 0

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        self.ticks += 1
        if self.ticks == 3:
            result: Proposal | None = self.misdeed(context)
            return result
        return Proposal(WheelCommand(500.0, 500.0), reason="faulty")


def propose(left: Any, right: Any = 0.0, activation: Any = 1.0) -> Callable[[Context], Any]:
    return lambda context: Proposal(WheelCommand(left, right), activation)


def leave(context: Context) -> None:
    raise SystemExit(0)


def flood(context: Context) -> Proposal:
    for _ in range(200):
        context.publish(Lost(time=context.time, reason="x"))
    return Proposal(AHEAD)


def flood_silently(context: Context) -> Proposal:
    for _ in range(200):
        with contextlib.suppress(AgentError):
            context.publish(Lost(time=context.time, reason="x"))
    return Proposal(AHEAD)


def leak(context: Context) -> Proposal:
    for _ in range(60):
        context.subscribe(Event, lambda event: None)
    return Proposal(AHEAD)


def dawdle(context: Context) -> Proposal:
    time.sleep(0.6)
    return Proposal(AHEAD)


class OwnBaseError(BaseException):
    pass


class MuteError(Exception):
    def __str__(self) -> str:
        raise KeyError("no text")


def raises(fault: BaseException) -> Callable[[Context], Proposal | None]:
    def misdeed(context: Context) -> Proposal | None:
        raise fault

    return misdeed


def publish(event: Event) -> Callable[[Context], Proposal | None]:
    def misdeed(context: Context) -> Proposal | None:
        context.publish(event)
        return None

    return misdeed


def publish_itself(context: Context) -> Proposal | None:
    data: dict[str, Any] = {}
    data["a"] = data["b"] = data
    return publish(PluginEvent(time=0.0, name="x", data=data))(context)


MISDEEDS = {
    "raises": (lambda context: 1 / 0, "ZeroDivisionError"),
    "exits": (leave, "SystemExit"),
    "NaN": (propose(math.nan), "not finite"),
    "inf": (propose(0.0, math.inf), "not finite"),
    "wild": (propose(1e6, -1e6), "wild"),
    "text": (propose("fast"), "TypeError"),
    "no proposal": (lambda context: (1.0, 2.0), "not tuple"),
    "activation": (propose(0.0, 0.0, 1.5), "activation must be in"),
    "activation NaN": (propose(0.0, 0.0, math.nan), "activation must be in"),
    "flood": (flood, "more than 100 events"),
    "silent flood": (flood_silently, "more than 100 events"),
    "leak": (leak, "more than 50 subscriptions"),
    "slow": (dawdle, "BudgetExceededError"),
    "base": (raises(OwnBaseError("x")), "OwnBaseError: x"),
    "generator exit": (raises(GeneratorExit()), "GeneratorExit"),
    "no text": (raises(MuteError()), "MuteError: (its text cannot be read)"),
    "event in itself": (publish_itself, "holds more than 20 levels"),
    "mapper's event": (publish(LoopClosed(time=0.0, node=9, met=9)), "cannot publish LoopClosed"),
    "event of wrong types": (publish(Lost(time="now", reason="x")), "Lost: time must be"),  # type: ignore[arg-type]
}


def agent_with(
    *behaviors: Behavior, limits: Limits = UNTIMED, **options: Any
) -> tuple[Agent, ScriptedRobot, list[Event]]:
    robot, heard = ScriptedRobot(), list[Event]()
    agent = Agent(robot, behaviors, limits=limits, **options)
    agent.bus.subscribe(Event, heard.append)
    for behavior in behaviors:
        agent.start(behavior.name)
    return agent, robot, heard


def ticks(agent: Agent, count: int) -> None:
    for _ in range(count):
        agent.tick()


@pytest.mark.parametrize("kind", MISDEEDS)
def test_a_faulty_behavior_is_stopped_and_the_others_go_on(
    kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    misdeed, said = MISDEEDS[kind]
    limits = Limits(budget=0.4) if kind == "slow" else UNTIMED
    agent, robot, heard = agent_with(Steady(), Faulty(misdeed), limits=limits)
    with caplog.at_level(logging.ERROR):
        ticks(agent, 5)
    assert [command.left for command in robot.commands] == [500.0, 500.0, 0.0, 100.0, 100.0]
    fault = event_of(heard, BehaviorFaulted)
    assert said in fault.fault
    assert (fault.behavior, fault.state, fault.disabled) == ("faulty", "ON", False)
    assert not agent.is_active("faulty")
    assert len(caplog.records) == 1
    assert "faulty stopped in state ON" in caplog.text
    assert agent.bus.subscriptions("faulty") == []


def test_a_speed_over_the_maximum_that_is_not_wild_is_clamped() -> None:
    agent, robot, heard = agent_with(Faulty(propose(2000.0, -2000.0)))
    ticks(agent, 3)
    assert robot.commands[2] == WheelCommand(1000.0, -1000.0)
    assert not any(isinstance(event, BehaviorFaulted) for event in heard)


def test_repeated_faults_disable_a_behavior() -> None:
    agent, _, heard = agent_with(Steady(), Faulty(lambda context: 1 / 0), max_faults=2)
    ticks(agent, 3)
    agent.start("faulty")
    ticks(agent, 3)
    faults = [event for event in heard if isinstance(event, BehaviorFaulted)]
    assert [fault.disabled for fault in faults] == [False, True]
    with pytest.raises(AgentError, match="'faulty' was disabled after 2 faults"):
        agent.start("faulty")


def test_a_reflex_is_started_again_until_it_is_disabled() -> None:
    class Reflex(Faulty):
        restarts = True

    agent, _, heard = agent_with(Steady(), Reflex(lambda context: 1 / 0), max_faults=2)
    ticks(agent, 20)
    faults = [event for event in heard if isinstance(event, BehaviorFaulted)]
    assert [fault.disabled for fault in faults] == [False, True]
    assert agent.driver == "steady"


def test_a_fault_in_on_start_is_contained() -> None:
    class Refusing(Steady):
        name = "refusing"

        def on_start(self, context: Context) -> None:
            raise ValueError("no such goal")

    agent, robot, heard = agent_with(Steady(), Refusing())
    ticks(agent, 2)
    assert "no such goal" in event_of(heard, BehaviorFaulted).fault
    assert robot.commands == [STOP, AHEAD]


def test_a_fault_in_on_stop_ends_nothing_else() -> None:
    class Clinging(Steady):
        name = "clinging"

        def on_stop(self, context: Context) -> None:
            raise RuntimeError("no")

    agent, robot, _ = agent_with(Steady(), Clinging())
    ticks(agent, 1)
    agent.stop("clinging")
    ticks(agent, 1)
    assert robot.commands[-1] == AHEAD


def test_a_raising_handler_stops_its_behavior_and_the_wheels() -> None:
    class Listening(Steady):
        name = "listening"
        priority = 30

        def on_start(self, context: Context) -> None:
            context.subscribe(Lost, self.hear)

        def hear(self, event: Lost) -> None:
            raise ZeroDivisionError

    agent, robot, heard = agent_with(Steady(), Listening())
    ticks(agent, 1)
    agent.bus.publish(Lost(time=0.0, reason=""))
    ticks(agent, 3)
    assert "ZeroDivisionError" in event_of(heard, BehaviorFaulted).fault
    assert robot.commands[2:] == [STOP, AHEAD]


def test_a_stopped_behaviors_subscriptions_end() -> None:
    heard = list[Event]()

    class Listening(Steady):
        name = "listening"

        def on_start(self, context: Context) -> None:
            context.subscribe(Lost, heard.append)

    agent, _, _ = agent_with(Listening())
    agent.stop("listening")
    agent.bus.publish(Lost(time=0.0, reason=""))
    ticks(agent, 1)
    assert heard == []


def test_a_python_loop_that_hangs_is_interrupted() -> None:
    def hang(context: Context) -> None:
        while True:
            pass

    agent, _, heard = agent_with(Steady(), Faulty(hang), limits=Limits(budget=None, hang=0.5))
    handler = signal.getsignal(signal.SIGALRM)
    ticks(agent, 4)
    assert signal.getsignal(signal.SIGALRM) is handler, "others' alarms must go on working"
    assert "still running after 0.5 s" in event_of(heard, BehaviorFaulted).fault


def test_each_of_two_agents_interrupts_what_hangs_in_it() -> None:
    agents = [Agent(ScriptedRobot(), [Endless()], limits=Limits(budget=None, hang=0.05)) for _ in range(2)]
    for agent in agents:
        agent.start("endless")
        agent.tick()
        assert not agent.is_active("endless")


class Endless(Behavior):
    """Never answers."""

    class States(Enum):
        ON = "on"

    name = "endless"
    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        while True:
            pass


def test_a_start_that_takes_long_by_its_nature_is_no_fault() -> None:
    class Slow(Endless):
        name = "slow"
        slow_start = True

        def on_start(self, context: Context) -> None:
            time.sleep(0.02)

        def on(self, percept: Percept, context: Context) -> Proposal | None:
            return None

    agent = Agent(ScriptedRobot(), [Slow()], limits=Limits(budget=0.01))
    agent.start("slow")
    assert agent.is_active("slow")


def test_no_behavior_can_change_what_another_sees() -> None:
    seen = []

    class Vandal(Steady):
        name = "vandal"
        priority = 90

        def on(self, percept: Percept, context: Context) -> Proposal | None:
            context.time = -1.0
            context.rng.random(7)
            return None

    class Witness(Steady):
        name = "witness"

        def on(self, percept: Percept, context: Context) -> Proposal | None:
            seen.append((context.time, context.rng.random()))
            return None

    for others in ([], [Vandal()]):
        agent, _, _ = agent_with(Witness(), *others)
        ticks(agent, 3)
    assert seen[:3] == seen[3:]


class Broken:
    name = "broken"

    def __init__(self, decision: Any) -> None:
        self.decision = decision

    def arbitrate(self, candidates: Any, previous: str | None) -> Decision:
        if self.decision is None:
            raise RuntimeError("no idea")
        decision: Decision = self.decision
        return decision

    def reset(self) -> None: ...


@pytest.mark.parametrize("decision", [None, Decision("steady", WheelCommand(math.nan, 0.0), ""), "steady"])
def test_a_broken_mediator_stops_the_wheels_and_priorities_take_over(decision: Any) -> None:
    agent, robot, heard = agent_with(Steady(), mediator=Broken(decision))
    ticks(agent, 2)
    assert robot.commands == [STOP, AHEAD]
    assert event_of(heard, MediatorFaulted).mediator == "broken"


def test_every_change_of_control_says_who_wanted_what_and_why() -> None:
    agent, _, heard = agent_with(Steady(), Faulty(lambda context: None))
    ticks(agent, 1)
    change = event_of(heard, ControlChanged)
    assert (change.previous, change.winner) == (None, "faulty")
    assert change.wanted == {"steady": 1.0, "faulty": 1.0}
    assert change.reasons["steady"] == "steady"
    assert "priority 20 over steady (10)" in change.reason


def test_a_finished_behavior_leaves_and_says_what_came_of_it() -> None:
    class Brief(Steady):
        name = "brief"

        def on(self, percept: Percept, context: Context) -> Proposal | None:
            self.finish(True, "there", result=4)
            return None

    agent, _, heard = agent_with(Brief())
    ticks(agent, 2)
    assert_event_order(heard, BehaviorStarted, BehaviorFinished)
    assert event_of(heard, BehaviorFinished).result == 4
    assert not agent.is_active("brief")


def test_a_suspended_behavior_is_not_asked_until_resumed() -> None:
    agent, robot, _ = agent_with(Steady())
    agent.suspend("steady")
    ticks(agent, 1)
    agent.resume("steady")
    ticks(agent, 1)
    assert robot.commands == [STOP, AHEAD]


def test_candidates_of_the_tick_can_be_read_afterwards() -> None:
    agent, _, _ = agent_with(Steady())
    ticks(agent, 1)
    assert list(agent.proposals) == [Candidate("steady", 10, Proposal(AHEAD, reason="steady"))]


def test_what_a_behavior_declares_is_taken_once() -> None:
    class Changing(Steady):
        name = "changing"

        def on_reset(self) -> None:
            super().on_reset()
            self.priority, self.name = "high", 7  # type: ignore[misc, assignment]

    agent = Agent(ScriptedRobot(), [Changing(), Steady()])
    agent.start("changing")
    agent.start("steady")
    ticks(agent, 2)
    assert [(each.name, each.priority) for each in agent.proposals] == [("changing", 10), ("steady", 10)]


def test_a_keyboard_interrupt_of_a_plugin_is_a_fault_and_the_users_is_not() -> None:
    agent, _, heard = agent_with(Faulty(raises(KeyboardInterrupt())))
    with raised():
        ticks(agent, 4)
    assert event_of(heard, BehaviorFaulted).fault == "KeyboardInterrupt"
    agent, _, _ = agent_with(Faulty(raises(UserInterrupt())))
    with pytest.raises(UserInterrupt):
        ticks(agent, 4)


def test_whether_and_how_it_finished_is_asked_under_watch() -> None:
    class Unsure(Steady):
        name = "unsure"
        ticks = 0

        @property
        def finished(self) -> bool:
            self.ticks += 1
            if self.ticks > 2:
                raise RuntimeError("cannot say")
            return False

        @finished.setter
        def finished(self, value: bool) -> None:
            """Not kept."""

    agent, robot, heard = agent_with(Unsure())
    ticks(agent, 3)
    assert "cannot say" in event_of(heard, BehaviorFaulted).fault
    assert robot.commands[-1] == STOP


def test_a_loop_that_swallows_interruptions_ends_the_process_in_one_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class EndedError(BaseException):
        pass

    def end(text: str) -> NoReturn:
        raise EndedError(text)

    monkeypatch.setattr("tolman.agent.containment.end_process", end)
    stopped: list[str] = []
    watch = Watchdog(None, 0.02, lambda: stopped.append("wheels"))
    with pytest.raises(EndedError, match="ran on after 5 interruptions; run it with --isolate"), watch:
        swallow()
    assert stopped == ["wheels"]


def swallow() -> None:
    while True:
        with contextlib.suppress(Exception):
            while True:
                pass
