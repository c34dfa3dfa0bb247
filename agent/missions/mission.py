"""Missions: generators that yield what they wait for, and the runner that resumes them.

def mission():
    yield Explore(side="left")
    for node in (yield Nodes()):
        yield OnFailure(GoTo(node), otherwise=Say(f"node {node} cannot be reached"))
    yield Save("a.tolman")
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import MissionError
from ..events import MissionEnded
from ..listener import Listener
from .files import script_in, steps_in
from .journal import Journal
from .runtime import Runtime, Thread
from .step import Body, Script, Site, Step, in_order
from .steps import STEPS

if TYPE_CHECKING:
    from ...world.robot import Percept
    from ..agent import Agent
    from ..behavior import Context


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
    def load(path: Path | str, further: Iterable[type[Step]] = ()) -> Mission:
        """Reads a mission from a .py file (a generator function `mission`) or a .yaml file.

        further: steps that a YAML file may name besides `STEPS`. Raises: MissionError with file and fault.
        """
        path = Path(path)
        if path.suffix == ".py":
            return Mission(path.stem, script_in(path))
        if path.suffix in (".yaml", ".yml"):
            name, steps = steps_in(path, (*STEPS, *further))
            return Mission.of(name, *(steps if isinstance(steps, tuple) else (steps,)))
        raise MissionError(f"{path}: a mission ends in .py, .yaml or .yml")


class Status(Enum):
    """How far a mission is."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class MissionRunner(Listener):
    """Runs one mission on an agent: a tick listener. Ends with `MissionEnded`.

    outcome: how it ended, with what the script returned. status: how it stands. said: what `Say` told so far.
    A fault in the mission's own code fails the mission, not the agent.
    """

    def __init__(
        self,
        mission: Mission,
        agent: Agent,
        site: Site,
        journal: Journal | None = None,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        """journal: where done steps are kept; one that was read again lets the mission skip them.

        say: is called with what `Say` tells, when it does.
        """
        super().__init__(agent)
        self.mission = mission
        self.status = Status.RUNNING
        self.said: list[str] = []
        self._agent = agent
        journal = journal if journal is not None else Journal()
        self._say = say
        self._root = Thread(mission.body, "", Runtime(agent, site, journal, self._hear))

    @property
    def doing(self) -> str:
        """The step under way, in words."""
        return self._root.doing

    def _hear(self, text: str) -> None:
        self.said.append(text)
        self._say(text)

    def update(self, percept: Percept, context: Context) -> None:
        """Resumes whatever need not wait any more."""
        outcome = self._root.poll(context.time)
        if outcome is not None:
            self.status = Status.DONE if outcome.succeeded else Status.FAILED
            self.finish(outcome.succeeded, outcome.result, outcome.reason)

    def stop(self, reason: str = "cancelled") -> None:
        """Ends the mission now: stops what its steps started, runs its `finally` blocks."""
        if not self.done:
            self._root.cancel()
            self.status = Status.CANCELLED
            self.finish(False, reason=reason)

    def finish(self, succeeded: bool, result: Any = None, reason: str = "") -> None:
        """Sets the outcome and tells it."""
        super().finish(succeeded, result, reason)
        ended = MissionEnded(
            time=self._agent.context.time, mission=self.mission.name, status=self.status.value, reason=reason
        )
        self._agent.bus.publish(ended)
