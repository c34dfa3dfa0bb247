"""What commands print and write: JSON on stdout, progress on stderr, output files checked beforehand."""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from ...files.messages import FileError
from ...files.reading import open_regular
from ...files.writing import check_target
from ..errors import UsageError
from ..plain import plain

if TYPE_CHECKING:
    from ..session.requests import Progress


def check_input(path: Path, what: str) -> Path:
    """The path of an existing, regular, readable file.

    Raises: UsageError, which names the file and says what it should be.
    """
    if not path.exists():
        raise UsageError(f"{path}: there is no such {what}")
    try:
        open_regular(path).close()
    except FileError as error:
        raise UsageError(f"{error}; it should be a {what}") from None
    return path


def check_output(path: Path, *, replace: bool, hint: str = "--force replaces it") -> Path:
    """The path, when a file can be written there; called before the work whose result it takes.

    Nothing is left behind. Raises: UsageError if the folder is missing or not writable, if there is something
    else than a regular file, or a file and `replace` is off; the message ends with `hint` then.
    """
    try:
        folder = check_target(path, replace=replace, hint=hint).parent
        with tempfile.TemporaryFile(dir=folder):
            return path
    except FileError as error:
        raise UsageError(str(error)) from None
    except OSError as error:
        raise UsageError(f"{path}: cannot write in {path.parent}: {error.strerror}") from None


def print_json(value: Mapping[str, Any] | list[Any]) -> None:
    """Prints one JSON document on stdout."""
    print(json.dumps(plain(value), indent=2, allow_nan=False))


@contextlib.contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Sends whatever is printed inside, by C++ libraries too, to stderr: DART warns on stdout."""
    sys.stdout.flush()
    saved = os.dup(1)
    try:
        os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).fflush(None)
        os.dup2(saved, 1)
        os.close(saved)


class ProgressLine:
    """Shows how far a run is on a stream: one line rewritten on a terminal, else a line now and then."""

    def __init__(self, stream: TextIO | None = None, interval: float = 5.0) -> None:
        """`interval`: least wall-clock seconds between two lines where the stream is no terminal."""
        self._stream = sys.stderr if stream is None else stream
        self._rewrites = self._stream.isatty()
        self._interval = 0.1 if self._rewrites else interval
        self._next = time.monotonic() + (0.0 if self._rewrites else 2.0)
        self._width = 0

    def show(self, text: str) -> None:
        """Shows `text`, unless the last one is too recent."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + self._interval
        if self._rewrites:
            self._stream.write("\r" + text.ljust(self._width))
            self._width = len(text)
        else:
            self._stream.write(text + "\n")
        self._stream.flush()

    def close(self) -> None:
        """Clears the line on a terminal."""
        if self._rewrites and self._width:
            self._stream.write("\r" + " " * self._width + "\r")
            self._stream.flush()
            self._width = 0

    def simulated(self, progress: Progress) -> None:
        """Shows how far a simulated run is."""
        nodes = f", {progress.nodes:3d} nodes" if progress.nodes is not None else ""
        self.show(f"{progress.time_s:7.0f} s simulated{nodes}  {progress.message}")


@contextlib.contextmanager
def progress_line() -> Iterator[ProgressLine]:
    """The line of a run inside, whatever else the run prints sent to stderr; cleared at the end."""
    line = ProgressLine()
    with stdout_to_stderr():
        try:
            yield line
        finally:
            line.close()
