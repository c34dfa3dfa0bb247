"""Soaks the agent in faulty plugins and counts what must not happen.

Run with `python -m tools.soak_faults [TICKS]`. Plugins raise, exit, return NaN and wild speeds,
dawdle, flood the bus, leak subscriptions and raise in handlers; each is started again after a while. Counted
are ticks in which the wheels turned by a stopped plugin's command, collisions then, and growth of memory.
"""

from __future__ import annotations

import logging
import math
import resource
import sys
import time
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, cast

import numpy as np
from tolman.agent import Agent, Behavior, Context, Proposal
from tolman.agent.events import BehaviorFaulted, Event, Lost
from tolman.agent.handle import Limits
from tolman.behaviors.free_itself import FreeItself
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.behaviors.wander import Wander
from tolman.world import open_world
from tolman.world.robot import STOP, Percept, Robot, WheelCommand

KINDS = ("raise", "exit", "nan", "wild", "slow", "flood", "leak", "handler", "no proposal")


class Faulty(Behavior):
    """Drives ahead at full speed and, now and then, does what its class is named for."""

    class States(Enum):
        """Only one."""

        ON = "on"

    initial = States.ON
    priority = 30
    kind = ""
    rate = 0.01

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        """Full speed ahead, or the misdeed."""
        if context.rng.random() < self.rate:
            return self._misbehave(context)
        return Proposal(WheelCommand(1000.0, 1000.0), 0.5, "ahead")

    def _misbehave(self, context: Context) -> Proposal | None:
        kind = self.kind
        if kind == "raise":
            raise RuntimeError("misdeed")
        if kind == "exit":
            raise SystemExit(1)
        if kind == "slow":
            time.sleep(0.003)
        elif kind == "flood":
            while True:
                context.publish(Lost(time=context.time, reason="flood"))
        elif kind == "leak":
            while True:
                context.subscribe(Lost, self._hear)
        elif kind == "handler":
            context.subscribe(Event, self._raise)
            context.publish(Lost(time=context.time, reason="handler"))
        elif kind == "no proposal":
            return "ahead"  # type: ignore[return-value]
        speed = {"nan": math.nan, "wild": 1e9}.get(kind, 1000.0)
        return Proposal(WheelCommand(speed, speed), 0.5, kind)

    def _hear(self, event: Event) -> None:
        """Hears and does nothing."""

    def _raise(self, event: Event) -> None:
        raise ValueError("misdeed in a handler")


class Witness:
    """Stands between agent and robot and notes whether who drives was stopped when the wheels are set."""

    def __init__(self, agent: Agent) -> None:
        """Takes the place of the agent's robot."""
        self._agent, self._robot = agent, agent.robot
        self.stopped = False
        agent.robot = cast(Robot, self)

    def __getattr__(self, name: str) -> Any:
        """All else that the robot has."""
        return getattr(self._robot, name)

    def act(self, command: WheelCommand) -> None:
        """Notes and passes on."""
        driver = self._agent.driver
        self.stopped = driver is not None and not self._agent.is_active(driver)
        self._robot.act(command)


@dataclass(slots=True)
class Count:
    """What was counted. memory: kB of growth after the first tenth."""

    ticks: int = 0
    faults: dict[str, int] = field(default_factory=dict)
    moved_after_fault: int = 0
    collisions: int = 0
    collisions_by_stopped: int = 0
    memory: int = 0
    seconds: float = 0.0
    slowest: float = 0.0


def soak(ticks: int, seed: int = 0) -> Count:
    """Runs that many ticks in env1's kinematic twin."""
    logging.disable(logging.ERROR)
    rng = np.random.default_rng(seed)
    world = open_world("env1", engine="kinematic", noise="thesis", seed=seed)
    plugins: list[Behavior] = [
        type(f"Faulty{index}", (Faulty,), {"name": f"faulty-{kind.replace(' ', '-')}", "kind": kind})()
        for index, kind in enumerate(KINDS)
    ]
    behaviors = [ObstacleAvoidance(), FreeItself(), Wander(), *plugins]
    agent = Agent(
        world.robots[0],
        behaviors,
        seed=np.random.SeedSequence(seed),
        max_faults=sys.maxsize,
        limits=Limits(budget=0.002),
    )
    count, faulted = Count(), list[str]()
    witness = Witness(agent)
    agent.bus.subscribe(BehaviorFaulted, lambda event: faulted.append(event.behavior))
    for behavior in behaviors:
        agent.start(behavior.name)
    began, base = time.perf_counter(), 0
    for tick in range(ticks):
        before, start = world.collisions(), time.perf_counter()
        command = agent.tick()
        count.slowest = max(count.slowest, time.perf_counter() - start)
        world.step()
        touched = world.collisions() > before
        count.collisions += touched
        for name in faulted:
            count.faults[name] = count.faults.get(name, 0) + 1
        if (witness.stopped or faulted) and command != STOP:
            count.moved_after_fault += 1
            count.collisions_by_stopped += touched
        faulted.clear()
        if rng.random() < 0.05:
            name = behaviors[int(rng.integers(len(behaviors)))].name
            if not agent.is_active(name):
                agent.start(name)
        if tick == ticks // 10:
            base = _memory()
    count.ticks, count.seconds, count.memory = ticks, time.perf_counter() - began, _memory() - base
    logging.disable(logging.NOTSET)
    return count


def _memory() -> int:
    """Largest resident memory so far, kB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


MOST_GROWTH = 4096
"""kB by which memory may grow after the first tenth."""


def main() -> int:
    """Prints what was counted. Status 1 if a stopped plugin moved the robot, or memory grew."""
    count = soak(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
    print(f"{count.ticks} ticks in {count.seconds:.0f} s, slowest {count.slowest * 1e3:.1f} ms")
    print(f"faults: {sum(count.faults.values())} {dict(sorted(count.faults.items()))}")
    print(f"moved by a stopped plugin: {count.moved_after_fault}, collisions {count.collisions_by_stopped}")
    print(f"collisions in all: {count.collisions}; memory grown by {count.memory} kB")
    return 1 if count.moved_after_fault or count.memory > MOST_GROWTH else 0


if __name__ == "__main__":
    sys.exit(main())
