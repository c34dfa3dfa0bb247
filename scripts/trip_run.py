"""Runs a trip over a saved map and scores where the robot truly ends."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict

from ..maps.hybrid_map import HybridMap
from ..maps.map_file import Truth, read_truth
from ..maps.meta import MapMeta
from ..world import World
from ..world.arenas import built_in_worlds, find_world
from ..world.robot import Pose, wrap_angle
from .profiles import AnyNavigator, find_profile, make_navigator
from .requests import GoReport, GoRequest, Progress, SessionError
from .wiring import load_settings, make_agent, make_world

LOST_BEYOND = 0.15
"""Meters from the node it says it is at beyond which a robot is lost."""
TIME_PER_METER = 120.0
"""Simulated seconds that a trip may take for each meter of its arcs, plus 120."""


def go_to(request: GoRequest, progress: Callable[[Progress], None] = lambda progress: None) -> GoReport:
    """Drives to a node of a map and reports.

    Raises: MapError, WorldError, SessionError, PluginError for a request that cannot be met; before the trip.
    """
    profile = find_profile(request.profile)
    settings = load_settings(request.config)
    hybrid_map = HybridMap.load(request.map)
    truth = read_truth(request.map)
    goal = hybrid_map.find(request.to)
    world_name = _world_of(request, hybrid_map.meta)
    start, node, arrival = _start(request, hybrid_map, truth)
    world = make_world(request, world_name, settings, start)
    try:
        agent = make_agent(request, world, settings)
        navigator = make_navigator(profile, agent, hybrid_map, node, arrival)
        return _drive(request, world, navigator, goal, truth, progress)
    finally:
        world.close()


def _world_of(request: GoRequest, meta: MapMeta) -> str:
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


def _start(request: GoRequest, hybrid_map: HybridMap, truth: Truth) -> tuple[Pose, int, str]:
    """Where the robot is put, and the node and arrival it is told. Raises: SessionError, MapError."""
    meta = hybrid_map.meta
    if request.origin is not None:
        node = hybrid_map.find(request.origin)
        if node not in truth.nodes:
            raise SessionError(f"{request.map}: the file does not say where node {node} truly is; use --at")
        return Pose(*truth.nodes[node]["pose"]), node, meta.side
    if meta.current_node is None or "pose" not in truth.run:
        raise SessionError(f"{request.map}: the file does not say where its robot was; use --from or --at")
    return Pose(*truth.run["pose"]), meta.current_node, meta.arrival or meta.side


def _drive(
    request: GoRequest,
    world: World,
    navigator: AnyNavigator,
    goal: int,
    truth: Truth,
    progress: Callable[[Progress], None],
) -> GoReport:
    began = time.perf_counter()
    agent = navigator.agent
    navigator.go(goal)
    length = sum(leg.distance for leg in navigator.planned)
    limit = 120.0 + TIME_PER_METER * length
    told = 0.0
    while not navigator.done and world.time < limit:
        agent.tick()
        world.step()
        if world.time - told >= 1.0:
            told = world.time
            progress(Progress(told, len(navigator.path), f"on the way to node {goal}"))
    reason = navigator.reason if navigator.done else f"not there after {limit:.0f} s"
    pose = world.true_pose()
    place = Pose(*truth.nodes[goal]["pose"]) if goal in truth.nodes else None
    error = None if place is None else place.distance_to(pose)
    turn = None if place is None else math.degrees(abs(wrap_angle(pose.heading - place.heading)))
    reached = navigator.reached
    return GoReport(
        reached=reached,
        lost=(reached and error is not None and error > LOST_BEYOND) or not reached,
        reason=reason,
        path=tuple(navigator.path),
        legs=tuple(_leg_values(asdict(leg)) for leg in navigator.legs),
        position_error_m=error,
        heading_error_deg=turn,
        distance_m=sum(leg.distance for leg in navigator.legs),
        collisions=world.collisions(),
        sim_time_s=world.time,
        wall_time_s=time.perf_counter() - began,
        seed=request.seed,
    )


def _leg_values(leg: dict[str, object]) -> dict[str, object]:
    return {
        "from": leg["source"],
        "to": leg["target"],
        "side": leg["side"],
        "distance_m": leg["distance"],
        "recognized": leg["recognized"],
    }
