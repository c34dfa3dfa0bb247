"""Request and report of a mission: the fields of `tolman run` and of its JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...world.robot import Pose
from .requests import Simulation


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRequest(Simulation):
    """A mission to run. world: None is the map's. max_time: simulated s after which it is cancelled.

    journal: where done steps are kept; resume: go on from there. force: `Save` may replace files.
    isolate: whether the behaviors of the plugin folders run in subprocesses.
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
    isolate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionReport:
    """How a mission ended. status: done, failed or cancelled."""

    mission: str
    status: str
    reason: str
    steps_done: int
    sim_time_s: float
    collisions: int
    seed: int

    def to_json(self) -> dict[str, Any]:
        """The fields as a dict of JSON values."""
        return asdict(self)
