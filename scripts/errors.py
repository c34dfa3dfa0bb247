"""Errors of the scripts: what they look like, and the exit status each stands for.

Standard library alone: loaded before the number of threads is fixed.
"""

from __future__ import annotations

from ..files.messages import did_you_mean as did_you_mean


class UsageError(ValueError):
    """A command line, or a file it names, that cannot be used; one line."""


class SessionError(ValueError):
    """A request that cannot be met: the wrong world for a map, a map that cannot be resumed."""


def describe(error: BaseException) -> str:
    """An error as one line."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    text = str(error.args[0]) if isinstance(error, LookupError) and error.args else str(error)
    return " ".join(text.split()) or type(error).__name__


def status_of(error: Exception) -> int | None:
    """The exit status an error stands for, or None for one that only a fault of ours can raise.

    Every package's errors also subclass the built-in they are: a RuntimeError is a run that failed, the
    others are input that cannot be used. Foreign errors are our faults, but for those of files.
    """
    ours = any(kind.__module__.partition(".")[0] == "tolman" for kind in type(error).__mro__)
    if ours:
        return 1 if isinstance(error, RuntimeError) else 2
    if isinstance(error, OSError):
        return 2 if isinstance(error, (FileNotFoundError, PermissionError, IsADirectoryError)) else 1
    return None
