"""Records a session: what happens, how the session is made again, and what code a replay of it would run.

A recording is data and names no code. Code runs that is on this machine as it was recorded, byte for byte, or
that the user trusts.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...agent.errors import RecordingError
from ...agent.recording.reader import Recording
from ...agent.recording.recorder import Recorder
from ...files.messages import FileError, printable, quoted
from ...files.reading import read_bytes
from ...plugins.description import described
from ..errors import SessionError

if TYPE_CHECKING:
    from ...world import WorldSpec
    from .requests import RunSettings
    from .stage import Stage

MAX_CODE = 10_000_000
"""Bytes of a file of code that is looked at."""


@contextlib.contextmanager
def recorded(
    path: Path | None,
    kind: str,
    request: RunSettings,
    stage: Stage,
    attachments: Mapping[str, bytes] | None = None,
) -> Iterator[None]:
    """Records what happens inside to `path`; does nothing for None.

    kind: "map", "go" or "mission". request: the session's, with all that makes it again. To be entered when
    the agents are made and nothing is started yet. Raises: SessionError for a session that has gone on.
    """
    if path is None:
        yield
        return
    world, agents = stage.world, stage.agents
    if stage.begun:
        raise SessionError(
            f"{path}: only a run from its start can be recorded; open another simulation for it"
        )
    header = {
        "kind": kind,
        "request": plain_request(request),
        "settings": stage.options,
        "seed": request.seed,
        "world": world.spec.name,
        "world_digest": world.spec.digest,
        "walls": outlines(world.spec),
        "robots": len(world.robots),
        "geometry": stage.agent.robot.geometry.name,
        "version": version("tolman"),
        "behaviors": [described(behavior) for behavior in stage.agent.behaviors.values()],
        "code": code_of(request.plugins),
    }
    truths = [partial(world.true_pose, index) for index in range(len(agents))]
    further = list(zip(agents[1:], truths[1:], strict=True))
    recorder = Recorder(path, stage.agent, header, truths[0], attachments, further)
    recorder.start()
    try:
        yield
    finally:
        recorder.close()


def outlines(spec: WorldSpec) -> list[list[list[float]]]:
    """Outlines (m) of all that stands in a world, rounded to 0.1 mm: for people to look at."""
    return [[[round(x, 4), round(y, 4)] for x, y in shape.outline()] for shape in spec.shapes]


def plain_request(request: RunSettings) -> dict[str, Any]:
    """A request as JSON values: paths as text but for outputs, which a replay does not write."""
    values = asdict(request)
    for name, value in values.items():
        if isinstance(value, Path):
            values[name] = str(value)
        elif isinstance(value, tuple):
            values[name] = [str(item) for item in value]
    return values


# --- whether a replay may run its code -------------------------------------------------------------------


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
