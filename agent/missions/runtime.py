"""How a mission's steps run: scripts that are resumed, and what they yield begun, kept and told."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...files.messages import quoted
from ..containment import describe as describe_fault
from ..errors import AgentError, MissionError, StepFailedError
from ..events import Said, StepEnded, StepStarted
from ..listener import Outcome
from .journal import Journal
from .step import MAX_DEPTH, Script, Site, Step, Task, describe, in_words, script_of

if TYPE_CHECKING:
    from ..agent import Agent

_AT_ONCE = 1000
"""Steps that one generator may take in a tick: an endless loop of steps without time must not hang."""


@dataclass(frozen=True, slots=True)
class Runtime:
    """What all parts of a running mission share: the `Run` of its steps."""

    agent: Agent
    site: Site
    journal: Journal
    hear: Callable[[str], None]

    def begin(self, body: Any, path: str) -> Task:
        """Starts whatever was yielded, or recalls it if it is done already."""
        if path.count(".") > MAX_DEPTH:
            raise MissionError(f"more than {MAX_DEPTH} steps within one another")
        kept = Kept(body, path, self)
        return Task(kept.poll, kept.cancel)

    def follow(self, script: Callable[[], Script], path: str) -> Task:
        """Starts a script, a step's own or a generator function that was yielded."""
        thread = Thread(script, f"{path}.", self)
        return Task(thread.poll, thread.cancel)

    def on_robot(self, index: int) -> Runtime:
        """The same with another robot."""
        agent, site = self.site.robot(index)
        return Runtime(agent, site, self.journal, self.hear)

    def say(self, text: str) -> None:
        """Tells a text to whoever follows the mission."""
        self.hear(text)
        self.agent.bus.publish(Said(time=self.agent.context.time, text=text))

    def make(self, body: Any, path: str) -> Task:
        """The task of a body that is not done yet."""
        if isinstance(body, Step):
            return body.begin(self, path)
        script = script_of(body)
        if script is None:
            raise MissionError(f"a mission yields steps such as GoTo(5), not {quoted(body)}")
        return self.follow(script, path)


class Kept:
    """A step with its place: recalled from the journal or done and recorded; its events published."""

    def __init__(self, body: Any, path: str, runtime: Runtime) -> None:
        """Starts it, unless the journal knows that it is done."""
        self._path, self._text, self._runtime = path, describe(body), runtime
        self._task = Task(lambda time: None)
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
            self._close(Outcome(False, reason=reason_of(fault)))

    def poll(self, time: float) -> Outcome | None:
        """The outcome, once there is one."""
        if self._early is not None:
            return self._early
        outcome = None
        try:
            outcome = self._task.poll(time)
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
        self._current: Task | None = None
        self._yielded: Any = None

    def poll(self, time: float) -> Outcome | None:
        """Resumes the script as often as it need not wait. Its faults become its outcome."""
        try:
            for _ in range(_AT_ONCE):
                outcome = Outcome(True) if self._current is None else self._current.poll(time)
                if outcome is None:
                    return None
                self._yielded = self._resume(outcome)
                self._count += 1
                self._current = None
                self._current = self._runtime.begin(self._yielded, f"{self._prefix}{self._count}")
            return None
        except StopIteration as stop:
            return Outcome(True, stop.value)
        except (StepFailedError, MissionError) as failed:
            self._close()
            return Outcome(False, reason=str(failed))
        except Exception as fault:
            self._close()
            return Outcome(False, reason=describe_fault(fault))

    @property
    def doing(self) -> str:
        """The step under way, in words."""
        return "" if self._yielded is None else in_words(self._yielded)

    def _resume(self, outcome: Outcome) -> Any:
        if self._current is None:
            return next(self._generator)
        if outcome.succeeded:
            return self._generator.send(outcome.result)
        return self._generator.throw(StepFailedError(self.doing, outcome.reason))

    def cancel(self) -> None:
        """Cancels what is under way and closes the script, whose `finally` blocks run."""
        if self._current is not None:
            self._current.cancel()
        self._close()

    def _close(self) -> None:
        # A `finally` that yields or raises: there is nobody left to hear of it.
        with contextlib.suppress(Exception):
            self._generator.close()


def reason_of(fault: Exception) -> str:
    """Why a step could not begin, in one line: what the error says, which is written for people."""
    text = fault.args[0] if isinstance(fault, KeyError) and fault.args else fault
    if isinstance(fault, OSError) and fault.strerror:
        text = f"{fault.filename}: {fault.strerror}" if fault.filename else fault.strerror
    return " ".join(str(text).split()) or type(fault).__name__
