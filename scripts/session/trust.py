"""What code the replay of a recording would run, and whether it may: a recording is data and names none.

Code runs that is on this machine as it was recorded, byte for byte, or that the user trusts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from ...agent.errors import RecordingError
from ...agent.recording.reader import Recording
from ...files.messages import FileError, printable, quoted
from ...files.reading import read_bytes

MAX_CODE = 10_000_000
"""Bytes of a file of code that is looked at."""


@dataclass(frozen=True, slots=True)
class Code:
    """A file or folder of code that a replay would run. known: whether it is here as it was recorded."""

    what: str
    known: bool

    def text(self) -> str:
        """In words."""
        return f"{self.what} ({'here as recorded' if self.known else 'not here as recorded'})"


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of the .py files of a folder by name. Raises: FileError for what cannot be read."""
    return {path.name: _digest(read_bytes(path, MAX_CODE)) for path in sorted(folder.glob("*.py"))}


def code_of(folders: Iterable[Path]) -> dict[str, dict[str, str]]:
    """What the header of a recording holds of plugin folders: the digests of their files by folder."""
    return {str(folder): digests(folder) for folder in folders}


def code_in(recording: Recording) -> list[Code]:
    """All code that a replay would run, but for what is installed. Raises: RecordingError."""
    asked = recording.header.get("request")
    asked = asked if isinstance(asked, Mapping) else {}
    found = []
    mission = str(asked.get("mission") or "")
    if Path(mission).suffix == ".py":
        attached = _digest(recording.attachments.get("mission", b""))
        found.append(Code(f"the mission {printable(mission)}", _is_here(Path(mission), attached)))
    kept = recording.header.get("code")
    folders = asked.get("plugins") or []
    if not isinstance(folders, list) or not all(isinstance(name, str) for name in folders):
        raise RecordingError(f"its plugins are {quoted(folders)}, not a list of folders")
    for name in folders:
        recorded = kept.get(name) if isinstance(kept, Mapping) else None
        here = _digests_or_none(Path(name))
        found.append(Code(f"the plugins in {printable(name)}", bool(here) and here == recorded))
    return found


def permitted(path: Path, recording: Recording, trust: bool) -> list[str]:
    """What code a replay will run, in words. Raises: RecordingError if it may not, and nobody trusts it."""
    code = code_in(recording)
    strange = [each for each in code if not each.known]
    if strange and not trust:
        raise RecordingError(
            f"{printable(str(path))}: a replay would run {', '.join(each.text() for each in strange)}; "
            "read it, and replay with --trust if it does no harm"
        )
    return [each.text() for each in code]


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


def _is_here(path: Path, digest: str) -> bool:
    try:
        return _digest(read_bytes(path, MAX_CODE)) == digest
    except FileError:
        return False


def _digests_or_none(folder: Path) -> dict[str, str] | None:
    try:
        return digests(folder)
    except (FileError, OSError, ValueError):
        return None
