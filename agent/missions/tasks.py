"""What a mission's single steps do while they are under way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from ..agent import Agent
from ..errors import MissionError
from ..events import BehaviorFaulted, BehaviorFinished, Event, Said
from .steps import Do, Explore, Fail, GoTo, Load, Look, Nodes, Place, Save, Say, Step, Until, Wait


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a step ended."""

    succeeded: bool
    value: Any = None
    reason: str = ""


class Task(Protocol):
    """A step under way."""

    def update(self, time: float) -> Outcome | None:
        """Called once a tick with the simulated time (s); returns the outcome when there is one."""

    def cancel(self) -> None:
        """Ends it before its time and stops what it started. Called at most once, never after the outcome."""


class Job(Protocol):
    """A drive under way, as a `Site` gives it: mapping, or a trip."""

    @property
    def outcome(self) -> Outcome | None:
        """None while it is under way."""

    def cancel(self) -> None:
        """Stops what it started."""


class Site(Protocol):
    """What a mission needs of the session it runs in: somebody who maps, navigates and keeps files."""

    def explore(self, step: Explore) -> Job:
        """Begins mapping."""

    def go_to(self, node: int | str) -> Job:
        """Begins a trip. Raises: LookupError or ValueError if there is no such node."""

    def save(self, path: str) -> None:
        """Saves the map."""

    def load(self, path: str) -> None:
        """Takes over a saved map."""

    def nodes(self) -> list[int]:
        """The map's nodes, sorted."""

    def place(self, node: int | str) -> int:
        """Puts the robot at a node and returns its number. Raises: MissionError where nobody can."""

    def robot(self, index: int) -> tuple[Agent, Site]:
        """Another robot of the same world, and what serves it. Raises: LookupError if there is none."""


def begin(step: Step, agent: Agent, site: Site) -> Task:
    """Starts a single step. Raises: MissionError for a step that none of these is."""
    if isinstance(step, Until):
        return _Waiting(step, agent)
    if isinstance(step, Do):
        return _Doing(step, agent)
    if isinstance(step, Wait):
        return _Timer(step, agent.context.time)
    if isinstance(step, Explore):
        job = site.explore(step)
        return _Driving(job) if step.wait else _At(Outcome(True))
    if isinstance(step, GoTo):
        return _Driving(site.go_to(step.node))
    return _At(_at_once(step, agent, site))


def _at_once(step: Step, agent: Agent, site: Site) -> Outcome:
    """The steps that take no time."""
    if isinstance(step, Save):
        site.save(step.path)
        return Outcome(True, step.path)
    if isinstance(step, Load):
        site.load(step.path)
        return Outcome(True, step.path)
    if isinstance(step, Place):
        return Outcome(True, site.place(step.node))
    if isinstance(step, Nodes):
        return Outcome(True, site.nodes())
    if isinstance(step, Look):
        return Outcome(True, agent.context.look())
    if isinstance(step, Say):
        agent.bus.publish(Said(time=agent.context.time, text=step.text))
        return Outcome(True)
    if isinstance(step, Fail):
        return Outcome(False, reason=step.reason)
    raise MissionError(f"a mission yields steps such as GoTo(5), not {step!r}")


class _At:
    """Is done at once."""

    def __init__(self, outcome: Outcome) -> None:
        self._outcome = outcome

    def update(self, time: float) -> Outcome | None:
        return self._outcome

    def cancel(self) -> None:
        """Nothing to stop."""


class _Timer:
    def __init__(self, step: Wait, now: float) -> None:
        self._end = now + step.seconds

    def update(self, time: float) -> Outcome | None:
        # Ticks are counted in floats: half a tick's tolerance keeps the count.
        return Outcome(True) if time >= self._end - 1e-6 else None

    def cancel(self) -> None:
        """Nothing to stop."""


class _Driving:
    def __init__(self, job: Job) -> None:
        self._job = job

    def update(self, time: float) -> Outcome | None:
        return self._job.outcome

    def cancel(self) -> None:
        self._job.cancel()


class _Waiting:
    def __init__(self, step: Until, agent: Agent) -> None:
        self._step = step
        self._end = None if step.timeout is None else agent.context.time + step.timeout
        self._event: Event | None = None
        self._subscription = agent.bus.subscribe(step.event, self._hear)

    def _hear(self, event: Event) -> None:
        fits = all(getattr(event, name, None) == value for name, value in self._step.where.items())
        if self._event is None and fits:
            self._event = event

    def update(self, time: float) -> Outcome | None:
        if self._event is not None:
            self._subscription.cancel()
            return Outcome(True, self._event)
        if self._end is not None and time >= self._end:
            self._subscription.cancel()
            return Outcome(False, reason=f"no {self._step.event.__name__} within {self._step.timeout:g} s")
        return None

    def cancel(self) -> None:
        self._subscription.cancel()


class _Doing:
    def __init__(self, step: Do, agent: Agent) -> None:
        self._agent, self._name = agent, step.behavior
        self._outcome: Outcome | None = None
        self._subscriptions = [
            agent.bus.subscribe(BehaviorFinished, self._finished),
            agent.bus.subscribe(BehaviorFaulted, self._faulted),
        ]
        agent.start(step.behavior, step.goal)

    def _finished(self, event: BehaviorFinished) -> None:
        if event.behavior == self._name and self._outcome is None:
            self._outcome = Outcome(event.succeeded, event.result, event.reason)

    def _faulted(self, event: BehaviorFaulted) -> None:
        if event.behavior == self._name and self._outcome is None:
            self._outcome = Outcome(False, reason=event.fault)

    def update(self, time: float) -> Outcome | None:
        if self._outcome is not None:
            self._release()
        return self._outcome

    def cancel(self) -> None:
        self._release()
        self._agent.stop(self._name)

    def _release(self) -> None:
        for subscription in self._subscriptions:
            subscription.cancel()
