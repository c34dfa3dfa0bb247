"""Replays recorded sessions: makes the session again and runs it on the recorded percepts and images."""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ...agent.containment import describe
from ...agent.errors import RecordingError
from ...agent.missions.mission import Mission
from ...agent.recording.reader import Recording, read_recording
from ...agent.recording.replay import Difference, ReplayEnded, ReplayWorld
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import read_truth
from ...world import World
from ...world.arenas.catalog import find_world
from ...world.robot import Pose
from .map_files import MapWriter
from .mapping import Mapping
from .mission import JOURNAL, MissionJob
from .recording import permitted
from .requests import GoRequest, MapRequest, MissionRequest, RunSettings, start_of_trip
from .settings import recorded_settings
from .site import sites_of
from .stage import Stage
from .trip import Trip
from .truth import poses_of


@dataclass(frozen=True, slots=True)
class ReplayReport:
    """What a replay found. ticks: how many were the same, of `recorded` ones.

    complete: whether the recording was not cut off.
    """

    kind: str
    ticks: int
    recorded: int
    difference: Difference | None
    complete: bool = True

    @property
    def identical(self) -> bool:
        """Whether every recorded tick was replayed to the bit."""
        return self.difference is None and self.ticks >= self.recorded


def replay(path: Path, trust: bool = False, tell: Callable[[str], None] = lambda text: None) -> ReplayReport:
    """Replays a recorded session. Raises: RecordingError if it cannot be made again here.

    trust: whether code may run that is not on this machine as it was recorded. tell: is told what code will.
    """
    recording = read_recording(path)
    for text in permitted(path, recording, trust):
        tell(text)
    try:
        return _replayed(path, recording)
    except (TypeError, ValueError, LookupError, AttributeError, OverflowError) as fault:
        if type(fault).__module__.startswith("tolman."):
            raise  # it says in one line what is wrong; the others come of a header that holds anything
        raise RecordingError(f"{path}: its session cannot be made again ({describe(fault)})") from fault


def _replayed(path: Path, recording: Recording) -> ReplayReport:
    kind = str(recording.header.get("kind"))
    if kind not in _REPLAYS:
        raise RecordingError(f"{path}: a recording of kind {kind!r}; known: {', '.join(_REPLAYS)}")
    asked = recording.header["request"]
    name = str(asked.get("world") or recording.header.get("world"))
    spec = find_world(name, float(asked.get("scale", 1.0)))
    if spec.digest != recording.header.get("world_digest"):
        raise RecordingError(f"{path}: recorded in another {name} than the one known by that name here")
    world = ReplayWorld(recording, spec)
    with contextlib.suppress(ReplayEnded), tempfile.TemporaryDirectory() as folder:
        _REPLAYS[kind](recording, world, Path(folder))
        world.step()  # the last tick's events
    complete = sum(tick.command is not None for tick in recording.ticks)
    return ReplayReport(kind, world.robot.ticks, complete, world.difference, recording.complete)


def _staged(recording: Recording, world: ReplayWorld, request: RunSettings) -> Stage:
    """The session again. It is not closed: the last command a recording has is not that."""
    options = recorded_settings(recording.header.get("settings", {}), "recording")
    return Stage(cast(World, world), request, options)


def _replay_mapping(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    output = folder / "replayed.tolman"
    resumed = bool(recording.header["request"].get("resume"))
    if resumed and "map" not in recording.attachments:
        raise RecordingError(
            "a mapping that was resumed, recorded by a tolman that did not keep its beginning"
        )
    for name, content in recording.attachments.items():
        output.with_name(output.name + name.removeprefix("map")).write_bytes(content)
    values = _common(recording, MapRequest)
    request = MapRequest(**values | {"output": output, "resume": resumed, "force": False, "start": None})
    stage = _staged(recording, world, request)
    with MapWriter.open(output, request, stage.map_meta(request)) as writer:
        mapping = Mapping(stage, request, writer=writer)
        world.robot.watch(stage.agent)
        mapping.drive()


def _replay_mission(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    if int(recording.header.get("robots", 1)) != 1 + len(recording.others):
        raise RecordingError("a mission of several robots, recorded by a tolman that kept only the first")
    values = _common(recording, MissionRequest)
    script = folder / Path(str(values["mission"])).name
    script.write_bytes(recording.attachments["mission"])
    values |= {"mission": script, "map": None, "start": None, "force": True}
    if "map" in recording.attachments:
        values["map"] = folder / "map.tolman"
        values["map"].write_bytes(recording.attachments["map"])
    request = MissionRequest(**values)
    stage = _staged(recording, world, request)
    sites = sites_of(stage, request, folder / "saved")
    journal = _resumed_journal(recording, folder)
    job = MissionJob(stage, sites, Mission.load(script), journal, resume=True)
    for robot, agent in zip(world.robots, stage.agents, strict=True):
        robot.watch(agent)
    job.drive(request.max_time)


def _resumed_journal(recording: Recording, folder: Path) -> Path | None:
    """The journal that the recorded mission went on from, with what stood beside it; None without one."""
    if JOURNAL not in recording.attachments:
        return None
    path = folder / JOURNAL
    for name, content in recording.attachments.items():
        if name.startswith(JOURNAL):
            path.with_name(name).write_bytes(content)
    return path


def _replay_trip(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    values = _common(recording, GoRequest)
    path = folder / "map.tolman"
    path.write_bytes(recording.attachments["map"])
    request = GoRequest(**values | {"map": path, "at": None if values["at"] is None else Pose()})
    hybrid_map, truth = HybridMap.load(path), read_truth(path)
    start = start_of_trip(request, hybrid_map, truth)
    stage = _staged(recording, world, request)
    world.robot.watch(stage.agent)
    trip = Trip(stage, hybrid_map, hybrid_map.find(request.to))
    limit = math.inf if request.max_time is None else request.max_time
    trip.drive(start.node, start.arrival, poses_of(truth), limit)


def _common(recording: Recording, kind: type[Any]) -> dict[str, Any]:
    """The recorded request's values that `kind` has, with paths as such; nothing is recorded again."""
    asked = recording.header["request"]
    values = {name: value for name, value in asked.items() if name in kind.__dataclass_fields__}
    values["plugins"] = tuple(Path(item) for item in asked.get("plugins", ()))
    return values | {"config": None, "record": None}


_REPLAYS = {"map": _replay_mapping, "go": _replay_trip, "mission": _replay_mission}
