"""Replays recorded sessions: makes the session again and runs it on the recorded percepts and images."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ...agent.containment import describe
from ...agent.errors import RecordingError
from ...agent.missions.journal import Journal
from ...agent.missions.mission import Mission
from ...agent.recording.reader import Recording, read_recording
from ...agent.recording.replay import Difference, ReplayEnded, ReplayWorld
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import read_truth
from ...world import World
from ...world.arenas.catalog import find_world
from ...world.robot import Pose
from .assembly import make_agent
from .mapping_run import MappingRun, open_map_file
from .mission_requests import MissionRequest
from .mission_session import JOURNAL, MissionSession
from .profiles import find_profile, make_navigator
from .requests import GoRequest, MapRequest, Progress
from .settings import Settings, recorded_settings
from .trip_run import Trip, start_of
from .trust import permitted


def _silent(progress: Progress) -> None:
    """Tells nobody."""


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
    complete = sum(tick.command is not None for tick in recording.ticks)
    return ReplayReport(kind, world.robot.ticks, complete, world.difference, recording.complete)


def _replay_mapping(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    output = folder / "replayed.tolman"
    resumed = bool(recording.header["request"].get("resume"))
    if resumed and "map" not in recording.attachments:
        raise RecordingError(
            "a mapping that was resumed, recorded by a tolman that did not keep its beginning"
        )
    for name, content in recording.attachments.items():
        output.with_name(output.name + name.removeprefix("map")).write_bytes(content)
    values = _common(dict(recording.header["request"]), MapRequest)
    values |= {
        "output": output,
        "resume": resumed,
        "force": False,
        "start": None,
        "record": None,
    }
    request = MapRequest(**values)
    stage = cast(World, world)
    with open_map_file(request, stage) as file:
        settings = _settings(recording)
        run = MappingRun(request, stage, file, settings, find_profile(request.profile), _silent)
        world.robot.watch(run.agent)
        run.drive()
        world.step()  # the last tick's events


def _settings(recording: Recording) -> Settings:
    return recorded_settings(recording.header.get("settings", {}), "recording")


def _replay_mission(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    if int(recording.header.get("robots", 1)) != 1 + len(recording.others):
        raise RecordingError("a mission of several robots, recorded by a tolman that kept only the first")
    asked = dict(recording.header["request"])
    script = folder / Path(str(asked["mission"])).name
    script.write_bytes(recording.attachments["mission"])
    values = _common(asked, MissionRequest) | {"mission": script, "journal": None, "resume": False}
    values |= {"map": None, "record": None, "start": None, "force": True}
    if "map" in recording.attachments:
        values["map"] = folder / "map.tolman"
        values["map"].write_bytes(recording.attachments["map"])
    values["journal"] = _resumed_journal(recording, folder)
    request = MissionRequest(**values)
    stage = cast(World, world)
    session = MissionSession(request, stage, _settings(recording), folder / "saved")
    mission = Mission.load(script)
    journal = Journal(request.journal, mission=mission.name, resume=True)
    if len(journal):
        session.restore()
    for robot, site in zip(world.robots, session.sites, strict=True):
        robot.watch(site.agent)
    session.run(mission, journal, _silent)
    world.step()  # the last tick's events


def _resumed_journal(recording: Recording, folder: Path) -> Path | None:
    """The journal that the recorded mission went on from, with what stood beside it; None: it began anew."""
    if JOURNAL not in recording.attachments:
        return None
    path = folder / JOURNAL
    for name, content in recording.attachments.items():
        if name.startswith(JOURNAL):
            path.with_name(name).write_bytes(content)
    return path


def _replay_trip(recording: Recording, world: ReplayWorld, folder: Path) -> None:
    asked = dict(recording.header["request"])
    path = folder / "map.tolman"
    path.write_bytes(recording.attachments["map"])
    values = _common(asked, GoRequest) | {"map": path, "at": None if asked["at"] is None else Pose()}
    request = GoRequest(**values)
    hybrid_map, truth = HybridMap.load(path), read_truth(path)
    _, node, arrival = start_of(request, hybrid_map, truth)
    stage = cast(World, world)
    agent = make_agent(request, stage, _settings(recording))
    world.robot.watch(agent)
    trip = Trip(request, stage, agent, _silent)
    node = trip.localize(hybrid_map) if node is None else node
    if node is not None:
        navigator = make_navigator(find_profile(request.profile), agent, hybrid_map, node, arrival)
        trip.drive(navigator, hybrid_map.find(request.to), truth)


def _common(asked: dict[str, Any], kind: type[Any]) -> dict[str, Any]:
    """The recorded request's values that `kind` has, with paths as such."""
    values = {name: value for name, value in asked.items() if name in kind.__dataclass_fields__}
    values["plugins"] = tuple(Path(item) for item in asked.get("plugins", ()))
    values["config"] = None
    return values | ({"record": None} if "record" in values else {})


_REPLAYS = {"map": _replay_mapping, "go": _replay_trip, "mission": _replay_mission}
