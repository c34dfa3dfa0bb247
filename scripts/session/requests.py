"""Requests and reports of mapping and of trips: the fields of the command line and of its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...world.robot import Pose


class SessionError(ValueError):
    """A request that cannot be met: the wrong world for a map, a map that cannot be resumed."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is. time_s: simulated seconds."""

    time_s: float
    nodes: int
    message: str


@dataclass(frozen=True, slots=True)
class Simulation:
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
class MapRequest(Simulation):
    """A mapping. See `tolman map --help` for what each means; max_time in simulated seconds.

    record: a file to record the run in, for replay. islands: whether to look, once the loop is closed, for
    obstacles that stand free.
    """

    world: str
    output: Path
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
class GoRequest(Simulation):
    """A trip. See `tolman go --help`; origin, at and lost exclude each other.

    record: a file to record the trip in, for replay.
    """

    map: Path
    to: int | str
    origin: int | str | None = None
    at: Pose | None = None
    lost: bool = False
    world: str | None = None
    learn: bool = False
    record: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MapReport:
    """How a mapping went. Lengths in m; the fields are those of `tolman map --json`.

    loop_distance_m: sum of the map's arcs once round. true_loop_distance_m: the same between this run's true
    node positions. position_error_m: their difference. path_integration_error_m: between raw path integration
    and the true position at the end. collisions: ticks in which the shell touched something. islands, forays:
    boundaries found by forays and lines driven; scouted: why the search for them ended, None without one.
    """

    nodes: int
    arcs: int
    local_maps: int
    loop_closed: bool
    loop_correct: bool | None
    reason: str
    loop_distance_m: float
    true_loop_distance_m: float
    position_error_m: float
    largest_arc_error_m: float
    path_integration_error_m: float
    collisions: int
    sim_time_s: float
    wall_time_s: float
    real_time_factor: float
    seed: int
    profile: str
    noise: str
    world: str
    version: str
    islands: int = 0
    forays: int = 0
    scouted: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The fields as a dict of JSON values."""
        values: dict[str, Any] = _rounded(asdict(self))
        return values


@dataclass(frozen=True, slots=True, kw_only=True)
class GoReport:
    """How a trip went. position_error_m: true robot to true node, None where the node has no true place.

    localized_node, localized_after_m: for a robot that was not told where it was: where it found out, after
    driving how far along the boundary.
    """

    reached: bool
    lost: bool
    reason: str
    path: tuple[int, ...]
    legs: tuple[Mapping[str, Any], ...]
    position_error_m: float | None
    heading_error_deg: float | None
    distance_m: float
    collisions: int
    sim_time_s: float
    wall_time_s: float
    seed: int
    localized_node: int | None = None
    localized_after_m: float | None = None

    def to_json(self) -> dict[str, Any]:
        """The fields as a dict of JSON values."""
        values: dict[str, Any] = _rounded(asdict(self))
        return values


def _rounded(values: Any) -> Any:
    """Floats to 1e-6: what is beyond is noise to a reader."""
    if isinstance(values, float):
        return round(values, 6)
    if isinstance(values, dict):
        return {name: _rounded(value) for name, value in values.items()}
    if isinstance(values, (list, tuple)):
        return [_rounded(value) for value in values]
    return values
