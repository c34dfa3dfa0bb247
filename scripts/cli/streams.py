"""What goes to stdout and stderr, whoever prints it: nothing that a terminal might obey.

Standard library alone: loaded before the number of threads is fixed.
"""

from __future__ import annotations

import contextlib
import sys
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
def escaped_streams() -> Iterator[None]:
    """Escapes what is printed inside, and shows each warning as one line without source code."""
    before = sys.stdout, sys.stderr, warnings.formatwarning
    try:
        if sys.stdout is not None:
            sys.stdout = cast(TextIO, EscapedStream(sys.stdout))
        if sys.stderr is not None:
            sys.stderr = cast(TextIO, EscapedStream(sys.stderr))
        warnings.formatwarning = _one_line
        yield
    finally:
        sys.stdout, sys.stderr, warnings.formatwarning = before


def _one_line(message: Warning | str, *_: Any, **__: Any) -> str:
    return f"tolman: warning: {' '.join(str(message).split())}\n"
