"""How the user ends a run: by Ctrl-C, or by a signal that asks a process to end; told apart from faults.

Standard library alone.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType, TracebackType
from typing import Any, Self

ASKING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that ask a process to end."""


class UserInterrupt(KeyboardInterrupt):
    """The user ends the run; no fault of a plugin. number: of the signal."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        """number: of the signal."""
        super().__init__()
        self.number = int(number)


def ends_run(fault: BaseException) -> bool:
    """Whether what came out of a plugin's code is the user's wish to end, not a fault of the plugin.

    A bare KeyboardInterrupt may be either where Python's own handler of Ctrl-C is in force: then it ends.
    """
    if isinstance(fault, UserInterrupt):
        return True
    ambiguous = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return isinstance(fault, KeyboardInterrupt) and ambiguous


class _Handlers:
    """Handles the signals that ask to end, while it is entered (main thread)."""

    def __init__(self, handler: Callable[[int, FrameType | None], Any]) -> None:
        self._handler = handler
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in ASKING:
                # Not where whoever started us has them ignored, as nohup does, or C code handles them.
                if signal.getsignal(number) not in (signal.SIG_IGN, None):
                    self._before[number] = signal.signal(number, self._handler)
        return self

    def __exit__(self, *_: object) -> None:
        while self._before:
            signal.signal(*self._before.popitem())


@contextlib.contextmanager
def raised() -> Iterator[None]:
    """Has a signal that asks to end raise UserInterrupt inside."""

    def raise_it(number: int, frame: FrameType | None) -> None:
        raise UserInterrupt(number)

    with _Handlers(raise_it):
        yield


class Deferred:
    """Lets the first signal that asks to end wait for `check`, or for the end of the block.

    So a tick is never cut in two. A second one is raised at once, unless `patient`.
    """

    def __init__(self, patient: bool = False) -> None:
        """patient: whether none is raised inside."""
        self._patient, self._asked = patient, 0
        self._handlers = _Handlers(self._ask)

    def __enter__(self) -> Self:
        """From now on they wait."""
        self._handlers.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """As before. Raises: UserInterrupt if one has come and nothing else is raised."""
        self._handlers.__exit__()
        if kind is None:
            self.check()

    def check(self) -> None:
        """Raises: UserInterrupt if a signal has come."""
        if self._asked:
            raise UserInterrupt(self._asked)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again, self._asked = self._asked, number
        if again and not self._patient:
            raise UserInterrupt(number)
