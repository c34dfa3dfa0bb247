"""What is asked of a session: its settings; a mapping, a trip or a mission; and where that begins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...agent.errors import MissionError
from ...maps.errors import MapError
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import Truth, read_truth
from ...world.arenas.catalog import built_in_worlds, find_world
from ...world.robot import Pose
from ..errors import SessionError as SessionError

if TYPE_CHECKING:
    from ...maps.meta import MapMeta


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is. time_s: simulated seconds. nodes: how many are known, None for a trip."""

    time_s: float
    nodes: int | None
    message: str


@dataclass(frozen=True, slots=True)
class RunSettings:
    """What every simulated run is made with.

    noise: a preset's name or values. config: a YAML file of settings. plugins: folders of behaviors.
    scale: what the lengths of a world from a file are multiplied by. isolate: whether the behaviors of the
    plugin folders run in subprocesses. robot: the address of a robot to drive in place of a simulated one.
    link: the model of a radio link to drive the simulated one over. calibration: what was measured of the
    robot behind either, a file.
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
    robot: str | None = None
    link: str | None = None
    calibration: Path | None = None


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


# --- where it begins -------------------------------------------------------------------------------------

_ANYWHERE = 7
"""What sets the draw of a start pose apart from the other uses of the seed."""


@dataclass(frozen=True, slots=True)
class Start:
    """pose: where the robot is put. node, arrival: where it is told that it is (or None), how it came."""

    pose: Pose
    node: int | None
    arrival: str


def world_of_trip(request: GoRequest, meta: MapMeta) -> str:
    """Name or path of the world to drive in. Raises: SessionError if it is not the map's, WorldError."""
    if request.robot is not None:
        return request.world or meta.world
    if request.world is None and meta.world not in built_in_worlds():
        raise SessionError(f"{request.map}: made in a world file called {meta.world!r}; name it with --world")
    name = request.world or meta.world
    spec = find_world(name, request.scale)
    if spec.digest != meta.world_digest and request.world is None:
        raise SessionError(
            f"{request.map}: made in another {spec.name} than the one known by that name here; "
            "name the world with --world"
        )
    if spec.digest != meta.world_digest and spec.name != meta.world:
        raise SessionError(f"{request.map}: a map of {meta.world}, not of {spec.name}")
    return name


def start_of_trip(request: GoRequest, hybrid_map: HybridMap, truth: Truth) -> Start:
    """Where a trip begins. Raises: SessionError, MapError."""
    meta = hybrid_map.meta
    if request.robot is not None:
        return _start_of_real_robot(request, hybrid_map)
    if request.at is not None:
        return Start(request.at, None, meta.side)
    if request.lost:
        return Start(_anywhere(request, hybrid_map, truth), None, meta.side)
    if request.origin is not None:
        node = hybrid_map.find(request.origin)
        if node not in truth.nodes:
            raise SessionError(f"{request.map}: the file does not say where node {node} truly is; use --at")
        return Start(Pose(*truth.nodes[node]["pose"]), node, meta.side)
    if meta.current_node is None or "pose" not in truth.run:
        raise SessionError(f"{request.map}: the file does not say where its robot was; use --from or --at")
    return Start(Pose(*truth.run["pose"]), meta.current_node, meta.arrival or meta.side)


def _start_of_real_robot(request: GoRequest, hybrid_map: HybridMap) -> Start:
    """Nobody knows its pose: where it stands is told by node, or found out."""
    meta = hybrid_map.meta
    if request.at is not None:
        raise SessionError("--at puts a simulated robot; say by --from at which node yours stands, or --lost")
    if request.lost:
        return Start(Pose(), None, meta.side)
    node = meta.current_node if request.origin is None else hybrid_map.find(request.origin)
    if node is None:
        raise SessionError(f"{request.map}: the file does not say where its robot was; use --from or --lost")
    arrival = meta.side if request.origin is not None else meta.arrival or meta.side
    return Start(Pose(), node, arrival)


def _anywhere(request: GoRequest, hybrid_map: HybridMap, truth: Truth) -> Pose:
    """A place on the mapped boundary, every meter equally likely, with any heading; as the seed says."""
    arcs = [
        (Pose(*truth.nodes[arc.start]["pose"]), Pose(*truth.nodes[arc.end]["pose"]))
        for arc in hybrid_map.arcs()
        if arc.kind == hybrid_map.meta.side and arc.start in truth.nodes and arc.end in truth.nodes
    ]
    if not arcs:
        raise SessionError(f"{request.map}: the file does not say where its nodes truly are; use --at")
    rng = np.random.default_rng(np.random.SeedSequence([request.seed, _ANYWHERE]))
    lengths = np.array([start.distance_to(end) for start, end in arcs])
    start, end = arcs[int(rng.choice(len(arcs), p=lengths / lengths.sum()))]
    share = rng.uniform()
    return Pose(
        start.x + share * (end.x - start.x),
        start.y + share * (end.y - start.y),
        rng.uniform(-math.pi, math.pi),
    )


def start_of_mission(request: MissionRequest) -> tuple[str, Pose | None]:
    """World and place (None: its first start) where a mission begins. Raises: MissionError, MapError."""
    if request.map is None:
        if request.world is None:
            raise MissionError("say in which world the mission runs (--world), or give a map (--map)")
        return request.world, request.start
    if request.robot is not None:
        return request.world or HybridMap.load(request.map).meta.world, None
    run = read_truth(request.map).run
    if "pose" not in run:
        raise MapError(f"{request.map}: the file does not say where its robot was")
    return request.world or HybridMap.load(request.map).meta.world, Pose(*run["pose"])
