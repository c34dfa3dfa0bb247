"""Behaviors that propose nothing and keep the goals they were given."""

from __future__ import annotations

from enum import Enum
from typing import Any

from tolman.agent import Agent
from tolman.agent.behavior import Behavior, Context, Proposal
from tolman.agent.events import BehaviorFinished
from tolman.agent.goals import (
    AlignToWall,
    DrivePath,
    ExploreLocally,
    Follow,
    Foray,
    GoAlong,
    LookAround,
    ReacquireCorner,
)
from tolman.plugins.testing import ScriptedRobot
from tolman.world.robot import Percept

GOALS: dict[str, type[Any]] = {
    "align-to-wall": AlignToWall,
    "foray": Foray,
    "go-to-node": GoAlong,
    "local-exploration": ExploreLocally,
    "local-go-to": DrivePath,
    "look-around": LookAround,
    "position-correction": ReacquireCorner,
    "reactive-wall-following": Follow,
    "wall-following": Follow,
}


class Idle(Enum):
    """Their only state."""

    IDLE = "idle"


class Puppet(Behavior):
    """Keeps the goals it was given."""

    States, initial = Idle, Idle.IDLE
    goals: list[Any]

    def on_start(self, context: Context) -> None:
        self.goals = [*getattr(self, "goals", []), self.goal]

    def idle(self, percept: Percept, context: Context) -> Proposal | None:
        return None


def puppets(*names: str) -> Agent:
    """An agent with a puppet of each name."""
    made = [
        type(f"Puppet{index}", (Puppet,), {"name": name, "Goal": GOALS.get(name)})()
        for index, name in enumerate(names)
    ]
    return Agent(ScriptedRobot(), made)


def goals(agent: Agent, name: str) -> list[Any]:
    """What the puppet of that name was asked for."""
    puppet: Any = agent.behavior(name)
    return list(getattr(puppet, "goals", []))


def finish(agent: Agent, name: str, result: Any = None, succeeded: bool = True, reason: str = "") -> None:
    """Has the agent hear that a behavior finished."""
    time = agent.context.time
    agent.bus.publish(
        BehaviorFinished(time=time, behavior=name, succeeded=succeeded, reason=reason, result=result)
    )
    agent.tick()
