"""Records sessions and replays them: which session a recording was, and how it is made again."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

from ..agent import Agent
from ..agent.errors import RecordingError
from ..agent.recording import Recorder, Recording, read_recording
from ..agent.replay import Difference, ReplayEnded, ReplayWorld
from ..world import World
from ..world.arenas import find_world
from .mapping_run import MappingRun, _open_file
from .profiles import find_profile
from .requests import MapRequest, Progress
from .wiring import load_settings, make_world

_PATHS = ("config", "output", "map", "record")


@contextlib.contextmanager
def recorded(
    path: Path | None,
    kind: str,
    request: Any,
    agent: Agent,
    world: World,
    attachments: Mapping[str, bytes] | None = None,
) -> Iterator[None]:
    """Records what happens inside to `path`; does nothing for None.

    kind: "map", "go" or "mission". request: the session's, with all that makes it again. To be entered when
    the agent is made and nothing is started yet.
    """
    if path is None:
        yield
        return
    header = {
        "kind": kind,
        "request": plain_request(request),
        "settings": load_settings(request.config),
        "seed": request.seed,
        "world": world.spec.name,
        "world_digest": world.spec.digest,
        "geometry": agent.robot.geometry.name,
        "version": version("tolman"),
    }
    recorder = Recorder(path, agent, header, world.true_pose, attachments)
    try:
        yield
    finally:
        recorder.close()


def plain_request(request: Any) -> dict[str, Any]:
    """A request as JSON values: paths as text but for outputs, which a replay does not write."""
    values = asdict(request)
    for name, value in values.items():
        if isinstance(value, Path):
            values[name] = str(value)
        elif isinstance(value, tuple):
            values[name] = [str(item) for item in value]
    return values


def _silent(progress: Progress) -> None:
    """Tells nobody."""


def record_mapping(request: MapRequest, path: Path) -> Any:
    """Maps a world as `map_world` does, and records the run. Returns the mapping's report."""
    settings = load_settings(request.config)
    world = make_world(request, request.world, settings, request.start or request.side)
    try:
        with _open_file(request, world) as file:
            run = MappingRun(request, world, file, settings, find_profile(request.profile), _silent)
            with recorded(path, "map", request, run.agent, world):
                run.drive()
            return run.report()
    finally:
        world.close()


@dataclass(frozen=True, slots=True)
class ReplayReport:
    """What a replay found. ticks: how many were the same, of `recorded` ones."""

    kind: str
    ticks: int
    recorded: int
    difference: Difference | None

    @property
    def identical(self) -> bool:
        """Whether every recorded tick was replayed to the bit."""
        return self.difference is None and self.ticks >= self.recorded


def replay(path: Path) -> ReplayReport:
    """Replays a recorded session. Raises: RecordingError if it cannot be made again here."""
    recording = read_recording(path)
    kind = str(recording.header.get("kind"))
    if kind not in _REPLAYS:
        raise RecordingError(f"{path}: a recording of kind {kind!r}; known: {', '.join(_REPLAYS)}")
    digest = find_world(str(recording.header["request"]["world"])).digest
    if digest != recording.header.get("world_digest"):
        raise RecordingError(
            f"{path}: recorded in another {recording.header['world']} than the one known here"
        )
    world = ReplayWorld(recording, find_world(str(recording.header["request"]["world"])))
    with contextlib.suppress(ReplayEnded), tempfile.TemporaryDirectory() as folder:
        _REPLAYS[kind](recording, world, Path(folder))
    complete = sum(tick.command is not None for tick in recording.ticks)
    return ReplayReport(kind, world.robot.ticks, complete, world.robot.difference)


def _replay_mapping(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    values = dict(recording.header["request"])
    values |= {"output": folder / "replayed.tolman", "config": None, "resume": False, "force": False}
    values["plugins"] = tuple(Path(item) for item in values.get("plugins", ()))
    values["start"] = None
    values = {name: value for name, value in values.items() if name in MapRequest.__dataclass_fields__}
    request = MapRequest(**values)
    stage = cast(World, world)
    with _open_file(request, stage) as file:
        settings = dict(recording.header["settings"])
        run = MappingRun(request, stage, file, settings, find_profile(request.profile), _silent)
        world.robot.watch(run.agent)
        run.drive()
        world.step()  # the last tick's events


_REPLAYS = {"map": _replay_mapping}
