"""Missions: generators that yield what they wait for, and the runner that resumes them.

def mission():
    yield Explore(side="left")
    for node in (yield Nodes()):
        yield OnFailure(GoTo(node), otherwise=Say(f"node {node} cannot be reached"))
    yield Save("a.tolman")
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from ...world.robot import Percept
from ..agent import Agent
from ..behavior import Context
from ..events import MissionEnded
from .journal import Journal
from .runtime import Runtime, Script, Thread, in_order
from .steps import Body
from .tasks import Site


@dataclass(frozen=True, slots=True)
class Mission:
    """A mission: its name, and the generator function that is its script."""

    name: str
    body: Callable[[], Script]

    @staticmethod
    def of(name: str, *bodies: Body) -> Mission:
        """A mission of these steps, one after the other."""
        return Mission(name, lambda: in_order(bodies))

    @staticmethod
    def load(path: Path | str) -> Mission:
        """Reads a mission from a .py file (a generator function `mission`) or a .yaml file.

        Raises: MissionError, which names file and fault.
        """
        from .files import load_mission

        return load_mission(Path(path))


class Status(Enum):
    """How far a mission is."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class MissionRunner:
    """Runs one mission on an agent, as one of its processes. Ends with `MissionEnded`.

    status, reason: how it stands. A fault in the mission's own code fails the mission, not the agent.
    """

    def __init__(self, mission: Mission, agent: Agent, site: Site, journal: Journal | None = None) -> None:
        """journal: where done steps are kept; one that was read again lets the mission skip them."""
        self.mission = mission
        self.status = Status.RUNNING
        self.reason = ""
        self.value: Any = None
        self._agent = agent
        self._root = Thread(
            mission.body, "", Runtime(agent, site, journal if journal is not None else Journal())
        )

    @property
    def ended(self) -> bool:
        """Whether nothing more will happen."""
        return self.status is not Status.RUNNING

    @property
    def doing(self) -> str:
        """The step under way, in words."""
        return self._root.doing

    def update(self, percept: Percept, context: Context) -> None:
        """Resumes whatever need not wait any more. Called once a tick by the agent."""
        if self.ended:
            return
        outcome = self._root.update(context.time)
        if outcome is not None:
            self.value = outcome.value
            self._end(Status.DONE if outcome.succeeded else Status.FAILED, outcome.reason)

    def cancel(self, reason: str = "cancelled") -> None:
        """Ends the mission now: stops what its steps started, runs its `finally` blocks."""
        if not self.ended:
            self._root.cancel()
            self._end(Status.CANCELLED, reason)

    def _end(self, status: Status, reason: str) -> None:
        self.status, self.reason = status, reason
        time = self._agent.context.time
        name = self.mission.name
        self._agent.bus.publish(MissionEnded(time=time, mission=name, status=status.value, reason=reason))
