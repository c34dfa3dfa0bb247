"""Judges what a behavior returned and how long it took; interrupts one that hangs."""

from __future__ import annotations

import math
import signal
import threading
import time
from types import FrameType
from typing import TYPE_CHECKING, Any

from ..world.robot import WheelCommand
from .declarations import Proposal
from .errors import BudgetExceededError

if TYPE_CHECKING:
    from .behavior import Behavior


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


def state_name(behavior: Behavior) -> str:
    """The name of the behavior's state, even of one whose `state` is broken."""
    try:
        state = behavior.state
        return str(getattr(state, "name", state))
    except Exception:
        return "unknown"


def describe(fault: BaseException) -> str:
    """A fault in one readable line of at most 200 characters."""
    try:
        text = " ".join(str(fault).split())
    except Exception:
        text = "(its text cannot be read)"
    return f"{type(fault).__name__}: {text}"[:200] if text else type(fault).__name__


class Watchdog:
    """Times a call of a behavior's code: `with watch: ...`; the end of it raises BudgetExceededError if late.

    budget: wall-clock s; None: as long as it takes. hang: s after which Python code is interrupted, None:
    never. That works only in the main thread of a POSIX process, and not in C code: run plugins nobody trusts
    in a subprocess (`--isolate`).
    """

    __slots__ = ("_armed", "_budget", "_hang", "_previous", "_started")

    def __init__(self, budget: float | None, hang: float | None = None) -> None:
        """With `hang` it takes over SIGALRM, within a call alone."""
        usable = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
        self._budget = math.inf if budget is None else budget
        self._hang = hang if usable else None
        self._armed = False
        self._started = 0.0
        self._previous: Any = None

    def __enter__(self) -> None:
        """Starts the clock."""
        if self._hang is not None:
            self._armed = True
            self._previous = signal.signal(signal.SIGALRM, self._expired)
            signal.setitimer(signal.ITIMER_REAL, self._hang, self._hang)
        self._started = time.perf_counter()

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        """Stops the clock. Raises: BudgetExceededError if it took too long and nothing else went wrong."""
        elapsed = time.perf_counter() - self._started
        if self._hang is not None:
            self._armed = False
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, self._previous or signal.SIG_DFL)
        if elapsed > self._budget and kind is None:
            raise BudgetExceededError(f"took {elapsed * 1e3:.0f} ms, more than {self._budget * 1e3:g} ms")

    def _expired(self, signum: int, frame: FrameType | None) -> None:
        # Not armed: it answered just now, and the agent's own code must not be interrupted.
        if self._armed:
            raise BudgetExceededError(f"still running after {self._hang:g} s")
