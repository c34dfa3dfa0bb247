"""How a mission's steps run: scripts that are resumed, groups of them at once, and what they yield kept."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeAlias

from ..agent import Agent
from ..containment import describe as describe_fault
from ..errors import AgentError, MissionError, StepFailedError
from ..events import StepEnded, StepStarted
from .journal import Journal
from .steps import As, ForEachNode, Nodes, OnFailure, Race, Repeat, Step, Together, Within, describe
from .tasks import Outcome, Site, begin

_AT_ONCE = 1000
"""Steps that one generator may take in a tick: an endless loop of steps without time must not hang."""

Script: TypeAlias = Generator[Any, Any, Any]


@dataclass(frozen=True, slots=True)
class Runtime:
    """What all parts of a running mission share."""

    agent: Agent
    site: Site
    journal: Journal

    def begin(self, body: Any, path: str) -> Kept:
        """Starts whatever was yielded, or recalls it if it is done already."""
        return Kept(body, path, self)

    def make(self, body: Any, path: str) -> Any:
        """The task of a body that is not done yet."""
        if isinstance(body, Race | Together):
            return _Group(body, path, self)
        if isinstance(body, As):
            agent, site = self.site.robot(body.robot)
            return Runtime(agent, site, self.journal).begin(body.body, f"{path}.1")
        if isinstance(body, Within):
            return _Limited(body, path, self)
        script = _script(body)
        if script is not None:
            return Thread(script, f"{path}.", self)
        return begin(body, self.agent, self.site)


class Kept:
    """A step with its place: recalled from the journal or done and recorded; its events published."""

    def __init__(self, body: Any, path: str, runtime: Runtime) -> None:
        """Starts it, unless the journal knows that it is done."""
        self._path, self._text, self._runtime = path, describe(body), runtime
        self._task: Any = None
        self._early = runtime.journal.recall(path, self._text)
        if self._early is not None:
            return
        agent = runtime.agent
        agent.bus.publish(StepStarted(time=agent.context.time, path=path, step=self._text))
        try:
            self._task = runtime.make(body, path)
        except MissionError:
            raise
        except (AgentError, LookupError, ValueError, OSError) as fault:
            self._close(Outcome(False, reason=describe_fault(fault)))

    def update(self, time: float) -> Outcome | None:
        """The outcome, once there is one."""
        if self._early is not None:
            return self._early
        outcome: Outcome | None
        try:
            outcome = self._task.update(time)
        except Exception as fault:
            outcome = Outcome(False, reason=describe_fault(fault))
        if outcome is not None:
            self._close(outcome)
        return outcome

    def cancel(self) -> None:
        """Stops it; it is not recorded as done."""
        if self._early is None:
            self._task.cancel()

    def _close(self, outcome: Outcome) -> None:
        self._early = outcome
        runtime = self._runtime
        runtime.journal.record(self._path, self._text, outcome)
        runtime.agent.bus.publish(
            StepEnded(
                time=runtime.agent.context.time,
                path=self._path,
                step=self._text,
                succeeded=outcome.succeeded,
                reason=outcome.reason,
            )
        )


class Thread:
    """A script under way: one generator, resumed with the outcome of what it yielded last."""

    def __init__(self, script: Callable[[], Script], prefix: str, runtime: Runtime) -> None:
        """prefix: the place of its steps in the mission, before their number."""
        self._runtime, self._prefix = runtime, prefix
        self._generator = script()
        self._count = 0
        self._current: Kept | None = None
        self._yielded: Any = None

    def update(self, time: float) -> Outcome | None:
        """Resumes the script as often as it need not wait. Its faults become its outcome."""
        try:
            for _ in range(_AT_ONCE):
                outcome = Outcome(True) if self._current is None else self._current.update(time)
                if outcome is None:
                    return None
                self._yielded = self._resume(outcome)
                self._count += 1
                self._current = None
                self._current = self._runtime.begin(self._yielded, f"{self._prefix}{self._count}")
            return None
        except StopIteration as stop:
            return Outcome(True, stop.value)
        except StepFailedError as failed:
            return Outcome(False, reason=str(failed))
        except Exception as fault:
            self._generator.close()
            return Outcome(False, reason=describe_fault(fault))

    @property
    def doing(self) -> str:
        """The step under way, in words."""
        return "" if self._yielded is None else describe(self._yielded)

    def _resume(self, outcome: Outcome) -> Any:
        if self._current is None:
            return next(self._generator)
        if outcome.succeeded:
            return self._generator.send(outcome.value)
        return self._generator.throw(StepFailedError(describe(self._yielded), outcome.reason))

    def cancel(self) -> None:
        """Cancels what is under way and closes the script, whose `finally` blocks run."""
        if self._current is not None:
            self._current.cancel()
        try:
            self._generator.close()
        except Exception:
            # A `finally` that yields or raises: there is nobody left to hear of it.
            self._current = None


class _Group:
    """Several bodies at once: a race, or all together."""

    def __init__(self, step: Race | Together, path: str, runtime: Runtime) -> None:
        if not step.bodies:
            raise MissionError(f"{type(step).__name__}() without steps")
        self._race = isinstance(step, Race)
        self._running = {
            index: runtime.begin(body, f"{path}.{index + 1}") for index, body in enumerate(step.bodies)
        }
        self._values: dict[int, Any] = {}
        self._failures: list[str] = []

    def update(self, time: float) -> Outcome | None:
        for index, task in list(self._running.items()):
            outcome = task.update(time)
            if outcome is None:
                continue
            del self._running[index]
            if outcome.succeeded:
                self._values[index] = outcome.value
            else:
                self._failures.append(outcome.reason)
            if outcome.succeeded is self._race:
                self.cancel()
                if self._race:
                    return Outcome(True, (index, outcome.value))
                return outcome
        if self._running:
            return None
        if self._race:
            return Outcome(False, reason="; ".join(self._failures))
        return Outcome(True, [self._values[index] for index in sorted(self._values)])

    def cancel(self) -> None:
        running, self._running = self._running, {}
        for task in running.values():
            task.cancel()


class _Limited:
    """A body with a limit of time."""

    def __init__(self, step: Within, path: str, runtime: Runtime) -> None:
        self._seconds = step.seconds
        self._end = runtime.agent.context.time + step.seconds
        self._task = runtime.begin(step.body, f"{path}.1")

    def update(self, time: float) -> Outcome | None:
        outcome = self._task.update(time)
        if outcome is None and time >= self._end:
            self._task.cancel()
            return Outcome(False, reason=f"not done within {self._seconds:g} s")
        return outcome

    def cancel(self) -> None:
        self._task.cancel()


def _script(body: Any) -> Callable[[], Script] | None:
    """The generator function of a body that consists of others, None for a single step."""
    if isinstance(body, Repeat):
        return lambda: _repeat(body)
    if isinstance(body, OnFailure):
        return lambda: _on_failure(body)
    if isinstance(body, ForEachNode):
        return lambda: _for_each_node(body)
    if isinstance(body, tuple):
        return lambda: in_order(body)
    if callable(body) and not isinstance(body, Step | type):
        generator: Callable[[], Script] = body
        return generator
    return None


def in_order(bodies: tuple[Any, ...]) -> Script:
    """One after the other; the last one's result."""
    value = None
    for body in bodies:
        value = yield body
    return value


def _repeat(step: Repeat) -> Script:
    value, done = None, 0
    while step.times is None or done < step.times:
        value = yield step.body
        done += 1
    return value


def _on_failure(step: OnFailure) -> Script:
    last: StepFailedError | None = None
    for _ in range(step.retries + 1):
        try:
            return (yield step.body)
        except StepFailedError as failed:
            last = failed
    if step.otherwise is None and last is not None:
        raise last
    return (yield step.otherwise)


def _for_each_node(step: ForEachNode) -> Script:
    for node in (yield Nodes()):
        yield step.body(node)
