"""What is asked of a session: the settings of every simulated run, and a mapping, a trip or a mission."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...world.robot import Pose
from ..errors import SessionError

__all__ = ["GoRequest", "MapRequest", "MissionRequest", "Progress", "RunSettings", "SessionError"]


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is. time_s: simulated seconds."""

    time_s: float
    nodes: int
    message: str


@dataclass(frozen=True, slots=True)
class RunSettings:
    """What every simulated run is made with.

    noise: a preset's name or values. config: a YAML file of settings. plugins: folders of behaviors.
    scale: what the lengths of a world from a file are multiplied by. isolate: whether the behaviors of the
    plugin folders run in subprocesses.
    """

    seed: int = 0
    noise: str = "thesis"
    noise_scale: float = 1.0
    profile: str = "default"
    model: str = "wheels"
    config: Path | None = None
    plugins: tuple[Path, ...] = ()
    engine: str = "dart"
    scale: float = 1.0
    isolate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MapRequest(RunSettings):
    """A mapping. See `tolman map --help` for what each means; max_time in simulated seconds.

    output: the map file; None keeps the map in memory. record: a file to record the run in, for replay.
    islands: whether to look, once the loop is closed, for obstacles that stand free.
    """

    world: str
    output: Path | None = None
    side: str = "right"
    global_only: bool = False
    max_nodes: int | None = None
    max_time: float | None = None
    strategy: str = "alternate"
    start: Pose | None = None
    islands: bool = False
    resume: bool = False
    force: bool = False
    record: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class GoRequest(RunSettings):
    """A trip. See `tolman go --help`; origin, at and lost exclude each other.

    max_time: simulated s after which it is given up. record: a file to record the trip in, for replay.
    """

    map: Path
    to: int | str
    origin: int | str | None = None
    at: Pose | None = None
    lost: bool = False
    world: str | None = None
    learn: bool = False
    max_time: float | None = None
    record: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRequest(RunSettings):
    """A mission to run. world: None is the map's. max_time: simulated s after which it is cancelled.

    journal: where done steps are kept; resume: go on from there. force: `Save` may replace files.
    """

    mission: Path
    world: str | None = None
    map: Path | None = None
    start: Pose | None = None
    global_only: bool = False
    max_time: float | None = None
    journal: Path | None = None
    resume: bool = False
    force: bool = False
    record: Path | None = None
