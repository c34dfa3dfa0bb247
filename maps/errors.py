"""What can go wrong with a map: one base error and what it is told apart by."""

from __future__ import annotations


class MapError(ValueError):
    """Base of everything the maps raise: one line saying what, where, and what would do."""


class NotTrainedError(MapError):
    """A map was asked before it was trained."""


class UnknownNodeError(MapError, LookupError):
    """No such node, arc or unit; the message names the known ones."""


class NoPathError(MapError, LookupError):
    """No way leads from start to goal."""


class MapFileError(MapError):
    """A map file cannot be read or written; the message names the file and the reason."""


class MapFileExistsError(MapFileError):
    """The file exists and overwriting it was not asked for."""


class MapFileDamagedError(MapFileError):
    """The file does not hold what its checksums say, or is not a map file at all."""


class MapFileVersionError(MapFileError):
    """The file has another format version than this program reads; an older one can be migrated."""


class MapFileLockedError(MapFileError):
    """Another process is writing the file."""


class NoMatchError(MapError):
    """Two maps could not be matched, or only ambiguously; nothing was merged."""


def some(names: object, limit: int = 12) -> str:
    """The first names of an iterable, for a message: `0, 1, 2, ... (30 in all)`."""
    known = [str(name) for name in names]  # type: ignore[attr-defined]
    if not known:
        return "none"
    shown = ", ".join(known[:limit])
    return shown if len(known) <= limit else f"{shown}, ... ({len(known)} in all)"
