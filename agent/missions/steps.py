"""The steps of a mission: what a mission yields, readable as a sentence.

A mission is a generator function. It yields a step, is resumed with the step's result when it is done, and
gets `StepFailedError` raised at the `yield` when it failed. Where a step takes others, each may be a step, a
tuple of steps (one after the other), or a generator function.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from .. import events
from ..errors import MissionError
from ..events import BehaviorFaulted, BehaviorFinished, Event
from ..listener import Outcome
from .composed import As as As
from .composed import ForEachNode as ForEachNode
from .composed import Nodes as Nodes
from .composed import OnFailure as OnFailure
from .composed import Race as Race
from .composed import Repeat as Repeat
from .composed import Together as Together
from .composed import Within as Within
from .forms import File, Flag, Form, Name, Node, Positive, Seconds, Text, one_of
from .step import UNKNOWN, Plan, Run, Task, describe, done, limited
from .step import Step as Step

if TYPE_CHECKING:
    from ...files.yaml_nodes import Entry


@dataclass(frozen=True, slots=True)
class Explore(Step):
    """Map the surroundings along the wall on `side`. Result: why it ended, such as "loop closed".

    wait: False starts it and goes on at once, to wait for events by `Until`. islands: whether to look for
    obstacles that stand free, once the loop is closed.
    """

    side: Annotated[str, one_of("right", "left")] = "right"
    strategy: Annotated[str, one_of("rows", "columns", "alternate")] = "alternate"
    max_nodes: Positive | None = None
    wait: Flag = True
    islands: Flag = False
    says, word, single = "explore along the {side} wall", "explore", "side"

    def begin(self, run: Run, path: str) -> Task:
        """Begins mapping."""
        job = run.site.explore(self.side, self.strategy, self.max_nodes, self.islands)
        return Task(lambda time: job.outcome, job.cancel) if self.wait else done()

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """From here on nobody knows what nodes the map has."""
        plan.nodes = None
        return UNKNOWN


@dataclass(frozen=True, slots=True)
class GoTo(Step):
    """Drive to a node of the map. Result: the node."""

    node: Node
    says, word, single = "go to node {node}", "go_to", "node"

    def begin(self, run: Run, path: str) -> Task:
        """Sets out."""
        job = run.site.go_to(self.node)
        return Task(lambda time: job.outcome, job.cancel)

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """Whether the map has that node."""
        if plan.nodes is None or not isinstance(self.node, int):
            return UNKNOWN
        if self.node not in plan.nodes:
            plan.problems.append(f"{describe(self)}: the map has no node {self.node}")
        return self.node


@dataclass(frozen=True, slots=True)
class Save(Step):
    """Save the map to a file. Result: the path."""

    path: File
    says, word, single = "save {path}", "save", "path"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        run.site.save(self.path)
        return done(self.path)


@dataclass(frozen=True, slots=True)
class Load(Step):
    """Take over the map in a file; the robot is taken to stand where it was when that was saved."""

    path: File
    says, word, single = "load {path}", "load", "path"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        run.site.load(self.path)
        return done(self.path)

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """From here on nobody knows what nodes the map has."""
        plan.nodes = None
        return UNKNOWN


@dataclass(frozen=True, slots=True)
class Place(Step):
    """Have somebody put the robot at a node, in its transition pose, as a simulation can. Result: it."""

    node: Node
    says, word, single = "put the robot at node {node}", "place", "node"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        return done(run.site.place(self.node))


@dataclass(frozen=True, slots=True)
class Look(Step):
    """Take a camera image, standing still. Result: (height, width) luminance in [0, 1]."""

    says, word = "take an image", "look"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        return done(run.agent.context.look())

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """A black image."""
        return np.zeros((16, 16), dtype=np.float32)


def _heard(
    run: Run,
    kinds: tuple[type[Event], ...],
    ending: Callable[[Event], Outcome | None],
    stop: Callable[[], None] = lambda: None,
) -> Task:
    """Ends with the first outcome that `ending` makes of an event of these types. stop: on `cancel`."""
    outcomes: list[Outcome] = []

    def hear(event: Event) -> None:
        outcome = ending(event)
        if outcome is not None:
            outcomes.append(outcome)

    subscriptions = [run.agent.bus.subscribe(kind, hear) for kind in kinds]

    def release() -> None:
        for subscription in subscriptions:
            subscription.cancel()

    def poll(time: float) -> Outcome | None:
        if not outcomes:
            return None
        release()
        return outcomes[0]

    def cancel() -> None:
        release()
        stop()

    return Task(poll, cancel)


def _goal(entry: Entry) -> Any:
    """A goal by its fields, such as `{turn: 1}`; the behavior makes its `Goal` of them."""
    value = entry.data()
    if value is not None and not isinstance(value, dict):
        raise entry.error("give the goal's fields, as {turn: 1}")
    return value


@dataclass(frozen=True, slots=True)
class Do(Step):
    """Start a behavior with a goal and wait until it has finished. Result: the behavior's."""

    behavior: Name
    goal: Annotated[Any, Form("a goal", lambda value: True, _goal)] = None
    says, word, single = "do {behavior}", "do", "behavior"

    def begin(self, run: Run, path: str) -> Task:
        """Starts the behavior."""
        run.agent.start(self.behavior, self.goal)
        return _heard(
            run, (BehaviorFinished, BehaviorFaulted), self._ending, lambda: run.agent.stop(self.behavior)
        )

    def _ending(self, event: Event) -> Outcome | None:
        if isinstance(event, BehaviorFinished) and event.behavior == self.behavior:
            return Outcome(event.succeeded, event.result, event.reason)
        if isinstance(event, BehaviorFaulted) and event.behavior == self.behavior:
            return Outcome(False, reason=event.fault)
        return None

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """Whether there is such a behavior."""
        if plan.behaviors is not None and self.behavior not in plan.behaviors:
            plan.problems.append(f"{describe(self)}: there is no such behavior")
        return UNKNOWN


_EVENTS = {
    name: value
    for name, value in vars(events).items()
    if isinstance(value, type) and issubclass(value, Event)
}
_EVENT = Form(
    "a class of events",
    lambda value: isinstance(value, type) and issubclass(value, Event),
    lambda entry: _EVENTS[entry.one_of(_EVENTS)],
)
_WHERE = Form("fields and their values", lambda value: isinstance(value, Mapping))


@dataclass(frozen=True, slots=True)
class Until(Step):
    """Wait for an event of a type. Result: the event. Fails after `timeout` simulated seconds.

    where: fields that must have these values.
    """

    event: Annotated[type[Event], _EVENT]
    timeout: Seconds | None = None
    where: Annotated[Mapping[str, Any], _WHERE] = field(default_factory=dict)
    says, word, single = "wait for {event.__name__}", "until", "event"

    def check(self) -> None:
        """Whether the event has the fields of `where`."""
        known = [each.name for each in fields(self.event)]
        for name in self.where:
            if name not in known:
                raise MissionError(f"{self.event.__name__} has no field {name!r}; known: {', '.join(known)}")

    def begin(self, run: Run, path: str) -> Task:
        """Begins to listen."""
        task = _heard(run, (self.event,), self._fitting)
        if self.timeout is None:
            return task
        end = run.agent.context.time + self.timeout
        return limited(task, end, f"no {self.event.__name__} within {self.timeout:g} s")

    def _fitting(self, event: Event) -> Outcome | None:
        fits = all(getattr(event, name) == value for name, value in self.where.items())
        return Outcome(True, event) if fits else None


@dataclass(frozen=True, slots=True)
class Wait(Step):
    """Let simulated seconds pass; whatever is active goes on."""

    seconds: Seconds
    says, word, single = "wait {seconds:g} s", "wait", "seconds"

    def begin(self, run: Run, path: str) -> Task:
        """Begins its time."""
        # Ticks are counted in floats: half a tick's tolerance keeps the count.
        end = run.agent.context.time + self.seconds - 1e-6
        return Task(lambda time: Outcome(True) if time >= end else None)


@dataclass(frozen=True, slots=True)
class Say(Step):
    """Tell whoever follows the mission."""

    text: Text
    says, word, single = "say {text!r}", "say", "text"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        run.say(self.text)
        return done()


@dataclass(frozen=True, slots=True)
class Fail(Step):
    """Fail, with a reason."""

    reason: Text
    says, word, single = "fail", "fail", "reason"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        return Task(lambda time: Outcome(False, reason=self.reason))


STEPS: tuple[type[Step], ...] = tuple(
    value
    for value in list(vars().values())
    if isinstance(value, type) and issubclass(value, Step) and value.word
)
"""The steps that YAML knows: all that are defined or imported here and have a word."""
