"""Judges what a behavior returned and published and how long it took; interrupts one that hangs."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, cast

from ..files.interrupts import ends_run
from ..files.messages import printable
from ..world.robot import WheelCommand
from .declarations import Proposal
from .errors import BudgetExceededError
from .events import (
    ArcAdded,
    BehaviorFaulted,
    BehaviorFinished,
    BehaviorStarted,
    ControlChanged,
    Event,
    Localized,
    LocalMapBuilt,
    LoopClosed,
    MediatorFaulted,
    MissionEnded,
    NodeCommitted,
    NodeCreated,
    NodeReached,
    StepEnded,
    StepStarted,
)
from .fields import verified

if TYPE_CHECKING:
    from .behavior import Behavior

LONGEST = 200
"""Characters of a fault's text."""
TEXT_TIME = 1.0
"""Wall-clock seconds after which whoever writes a fault's text is interrupted."""
STRIKES = 5
"""Interruptions after which code that goes on ends the process."""


def check_proposal(proposal: Any, wildest: float) -> None:
    """Raises TypeError or ValueError, saying what is wrong, if this is not a proposal to drive by.

    wildest: steps/s; a speed beyond it is a fault. What lies between it and the robot's maximum is clamped.
    """
    if type(proposal) is not Proposal:
        raise TypeError(f"propose must return a Proposal or None, not {type(proposal).__name__}")
    command = proposal.command
    if type(command) is not WheelCommand:
        raise TypeError(f"the proposed command must be a WheelCommand, not {type(command).__name__}")
    check_command(command, wildest)
    if not 0.0 <= proposal.activation <= 1.0:
        raise ValueError(f"activation must be in [0, 1], not {proposal.activation!r}")


def check_command(command: WheelCommand, wildest: float) -> None:
    """Raises ValueError if the command is not finite or wilder than `wildest` (steps/s)."""
    left, right = command.left, command.right
    if -wildest <= left <= wildest and -wildest <= right <= wildest:
        return  # false for NaN too
    if not (math.isfinite(left) and math.isfinite(right)):
        raise ValueError(f"the proposed command is not finite: {command!r}")
    raise ValueError(f"the proposed command is wild: {command!r}, beyond {wildest:g} steps/s")


DEPTH, MOST = 20, 100_000
"""Levels and values of what is published or returned as a result."""
_SIMPLE = (bool, int, float, str, type(None))


NOT_A_BEHAVIORS = (
    ControlChanged,
    BehaviorStarted,
    BehaviorFinished,
    BehaviorFaulted,
    MediatorFaulted,
    NodeCreated,
    NodeCommitted,
    ArcAdded,
    LocalMapBuilt,
    LoopClosed,
    NodeReached,
    Localized,
    StepStarted,
    StepEnded,
    MissionEnded,
)
"""What only the agent, a mapper, a navigator or a mission can know: who hears it builds on it."""


def checked_event(event: Any) -> Event:
    """What a behavior publishes, its fields checked by their types.

    Raises: TypeError or ValueError, saying why, for what a behavior cannot publish.
    """
    cls = type(event)
    if not issubclass(cls, Event) or type(cls) is not type:
        raise TypeError(f"only events can be published, not {cls.__name__}")
    if issubclass(cls, NOT_A_BEHAVIORS):
        raise TypeError(f"a behavior cannot publish {cls.__name__}; use PluginEvent, or `finish`")
    check_plain(event)
    return (
        cast(Event, verified(event, cls.__name__))
        if cls.__module__ == Event.__module__
        else cast(Event, event)
    )


def check_plain(value: Any) -> None:
    """Raises ValueError for a value that contains itself or far too much, as nobody could keep it."""
    level, count = [value], 0
    for _ in range(DEPTH):
        level = [part for each in level for part in _parts(each)]
        count += len(level)
        if not level:
            return
        if count > MOST:
            break
    raise ValueError(f"an event or a result holds more than {DEPTH} levels or {MOST} values, or itself")


def _parts(value: Any) -> list[Any]:
    """What a container holds that may hold more."""
    if is_dataclass(value) and not isinstance(value, type):
        held: Any = [getattr(value, each.name) for each in fields(value)]
    elif isinstance(value, Mapping):
        held = value.values()
    elif isinstance(value, list | tuple | set | frozenset):
        held = value
    else:
        return []
    if len(held) > MOST:
        raise ValueError(f"an event or a result holds more than {MOST} values")
    return [part for part in held if type(part) not in _SIMPLE]


def state_name(behavior: Behavior) -> str:
    """The name of the behavior's state, even of one whose `state` is broken."""

    def name() -> str:
        state = behavior.state
        return str(getattr(state, "name", state))

    return _foreign_text(name, "unknown")


def describe(fault: BaseException, kind: bool = True) -> str:
    """A fault in one readable line of at most 200 characters. kind: whether its class comes first."""
    text = _foreign_text(lambda: str(fault), "(its text cannot be read)")
    name = _foreign_text(lambda: type(fault).__name__, "a fault")
    if not text:
        return name
    return f"{name}: {text}"[:LONGEST] if kind else text


def _foreign_text(ask: Callable[[], str], otherwise: str) -> str:
    """A line of text that code of a plugin may have to tell."""
    try:
        with Watchdog(None, TEXT_TIME):
            return printable(" ".join(ask()[: 10 * LONGEST].split()))[:LONGEST]
    except BaseException as fault:
        if ends_run(fault):
            raise
        return otherwise


def end_process(text: str) -> NoReturn:
    """Ends the process at once, with one line on stderr: where a plugin lets nothing else end it."""
    with contextlib.suppress(OSError):
        os.write(2, f"tolman: error: {text}\n".encode(errors="replace"))
    os._exit(1)


class Watchdog:
    """Times a call of a behavior's code: `with watch: ...`; the end of it raises BudgetExceededError if late.

    budget: wall-clock s; None: as long as it takes. hang: s after which Python code is interrupted, None:
    never; again and again for code that goes on, and the fifth time the process ends. That works only in the
    main thread of a POSIX process, and not in C code: run plugins nobody trusts in a subprocess.
    before_end: called before the process ends, to stop the wheels.
    """

    __slots__ = ("_armed", "_before_end", "_budget", "_hang", "_outer", "_previous", "_started", "_strikes")

    def __init__(
        self,
        budget: float | None,
        hang: float | None = None,
        before_end: Callable[[], object] = lambda: None,
    ) -> None:
        """With `hang` it takes over SIGALRM, within a call alone."""
        usable = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
        self._budget = math.inf if budget is None else budget
        self._hang = hang if usable else None
        self._before_end = before_end
        self._armed = False
        self._started = 0.0
        self._strikes = 0
        self._previous: Any = None
        self._outer = (0.0, 0.0)

    def __enter__(self) -> None:
        """Starts the clock."""
        if self._hang is not None:
            self._armed, self._strikes = True, 0
            self._previous = signal.signal(signal.SIGALRM, self._expired)
            self._outer = signal.setitimer(signal.ITIMER_REAL, self._hang, self._hang)
        self._started = time.perf_counter()

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        """Stops the clock. Raises: BudgetExceededError if it took too long and nothing else went wrong."""
        elapsed = time.perf_counter() - self._started
        if self._hang is not None:
            self._armed = False
            signal.setitimer(signal.ITIMER_REAL, *self._outer)  # of the call around this one, if there is one
            signal.signal(signal.SIGALRM, self._previous or signal.SIG_DFL)
        if elapsed > self._budget and kind is None:
            raise BudgetExceededError(f"took {elapsed * 1e3:.0f} ms, more than {self._budget * 1e3:g} ms")

    def _expired(self, signum: int, frame: FrameType | None) -> None:
        # Not armed: it answered just now, and the agent's own code must not be interrupted.
        if not self._armed:
            return
        self._strikes += 1
        if self._strikes >= STRIKES:
            self._before_end()
            end_process(f"a plugin ran on after {STRIKES} interruptions; run it with --isolate")
        raise BudgetExceededError(f"still running after {self._hang:g} s")
