"""What goes to stdout and stderr, whoever prints it: nothing that a terminal might obey.

Standard library alone: loaded before the number of threads is fixed.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import warnings
from collections.abc import Iterator
from typing import Any, TextIO, cast

from ...files.messages import printable


class EscapedStream:
    """A text stream that escapes control characters (see `printable`), but for line ends and tabs."""

    def __init__(self, stream: TextIO) -> None:
        """Writes to `stream`, and is like it in all else."""
        self._stream = stream

    def write(self, text: str) -> int:
        """Writes the text; returns how many characters that took."""
        return self._stream.write(printable(text, keep="\n\t\r"))

    def __getattr__(self, name: str) -> Any:
        """What the stream has."""
        return getattr(self._stream, name)


@contextlib.contextmanager
def _named(stream: str) -> Iterator[None]:
    """Has an error of the system name the stream."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, stream) from None


class ResultStream(EscapedStream):
    """For stdout: threads that a plugin has left behind spoil no result; what they print goes to stderr."""

    def write(self, text: str) -> int:
        """Writes the text; returns how many characters that took."""
        if threading.current_thread() is not threading.main_thread():
            return sys.stderr.write(text)
        with _named("stdout"):
            return super().write(text)

    def flush(self) -> None:
        """Hands on what was written."""
        with _named("stdout"):
            self._stream.flush()


class MessageStream(EscapedStream):
    """For stderr: a message that nobody takes, as the disk is full, is lost and ends nothing."""

    def write(self, text: str) -> int:
        """Writes the text, or not."""
        try:
            return super().write(text)
        except (OSError, ValueError):
            return len(text)

    def flush(self) -> None:
        """Hands on what was written, or not."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.flush()


@contextlib.contextmanager
def escaped_streams() -> Iterator[None]:
    """Escapes what is printed inside, and shows each warning as one line without source code.

    A stream that is closed is a null device.
    """
    before = sys.stdout, sys.stderr, warnings.formatwarning
    with open(os.devnull, "w", encoding="utf-8") as nobody:
        try:
            sys.stdout = cast(TextIO, ResultStream(sys.stdout or nobody))
            sys.stderr = cast(TextIO, MessageStream(sys.stderr or nobody))
            warnings.formatwarning = _one_line
            yield
        finally:
            sys.stdout, sys.stderr, warnings.formatwarning = before


def open_standard_streams() -> None:
    """Puts the null device where stdin, stdout or stderr are closed: else a file would get their number."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


def flushed(stream: TextIO | None, number: int) -> bool:
    """Whether what was written has arrived; what has not is dropped, so that nothing complains at the end."""
    try:
        if stream is not None:
            stream.flush()
        return True
    except (OSError, ValueError):
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
        return False


def _one_line(message: Warning | str, *_: Any, **__: Any) -> str:
    return f"tolman: warning: {' '.join(str(message).split())}\n"
