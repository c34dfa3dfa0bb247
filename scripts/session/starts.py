"""Where a session over a saved map begins: which world, which place, and what the robot knows of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...agent.errors import MissionError
from ...maps.errors import MapError
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import Truth, read_truth
from ...world.arenas.catalog import built_in_worlds, find_world
from ...world.robot import Pose
from ..errors import SessionError

if TYPE_CHECKING:
    from ...maps.meta import MapMeta
    from .requests import GoRequest, MissionRequest

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
    run = read_truth(request.map).run
    if "pose" not in run:
        raise MapError(f"{request.map}: the file does not say where its robot was")
    return request.world or HybridMap.load(request.map).meta.world, Pose(*run["pose"])
