"""Runs a trip over a saved map and scores where the robot truly ends."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...agent import Agent
from ...agent.events import Stuck
from ...agent.goals import LegDriven
from ...agent.localization.localizer import Localizer
from ...agent.navigation.base import AnyNavigator
from ...agent.navigation.corners import Navigator
from ...agent.navigation.recovery import TIME_PER_METER, RecoveringNavigator
from ...maps.hybrid_map import HybridMap
from ...maps.meta import MapMeta
from ...maps.sides import other_side
from ...maps.storage.map_file import MapFile, Truth, read_truth
from ...world import World
from ...world.arenas.catalog import built_in_worlds, find_world
from ...world.robot import Pose, wrap_angle
from .assembly import make_agent, make_world
from .profiles import find_profile, make_navigator
from .record_run import recorded
from .requests import GoReport, GoRequest, Progress, SessionError, Simulation
from .settings import load_settings

LOST_BEYOND = 0.15
"""Meters from the node it says it is at beyond which a robot is lost."""
_ANYWHERE = 7
"""What sets the draw of a start pose apart from the other uses of the seed."""


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
    start, node, arrival = start_of(request, hybrid_map, truth)
    world = make_world(request, world_name, settings, start)
    try:
        agent = make_agent(request, world, settings)
        trip = Trip(request, world, agent, progress)
        with recorded(request.record, "go", request, agent, world, {"map": request.map.read_bytes()}):
            if node is None:
                node = trip.localize(hybrid_map)
            if node is None:
                return trip.give_up()
            report = trip.drive(make_navigator(profile, agent, hybrid_map, node, arrival), goal, truth)
        if request.learn:
            learn(request.map, report, trip.blocked)
        return report
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


def start_of(request: GoRequest, hybrid_map: HybridMap, truth: Truth) -> tuple[Pose, int | None, str]:
    """Where the robot is put, and the node (None: not told) and arrival. Raises: SessionError, MapError."""
    meta = hybrid_map.meta
    if request.at is not None:
        return request.at, None, meta.side
    if request.lost:
        return _anywhere(request, hybrid_map, truth), None, meta.side
    if request.origin is not None:
        node = hybrid_map.find(request.origin)
        if node not in truth.nodes:
            raise SessionError(f"{request.map}: the file does not say where node {node} truly is; use --at")
        return Pose(*truth.nodes[node]["pose"]), node, meta.side
    if meta.current_node is None or "pose" not in truth.run:
        raise SessionError(f"{request.map}: the file does not say where its robot was; use --from or --at")
    return Pose(*truth.run["pose"]), meta.current_node, meta.arrival or meta.side


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


class Trip:
    """One trip: finding out where it is, if it was not told, and driving."""

    def __init__(
        self, request: Simulation, world: World, agent: Agent, progress: Callable[[Progress], None]
    ) -> None:
        """At the start; the clock of the computer runs from here."""
        self.request, self.world, self.agent, self.progress = request, world, agent, progress
        self._began = time.perf_counter()
        self._told = 0.0
        self._stuck = False
        agent.bus.subscribe(Stuck, self._on_stuck)
        self._localizer: Localizer | None = None
        self.blocked: list[tuple[int, int, str]] = []
        self.attempts = 0

    @property
    def localizer(self) -> Localizer:
        """What found out last where the robot is, or is at it. Raises: SessionError if nothing ever did."""
        if self._localizer is None:
            raise SessionError("this trip never had to find out where it is")
        return self._localizer

    def localize(self, hybrid_map: HybridMap) -> int | None:
        """Drives along the boundary until the robot knows where it is; None if it never does."""
        self._localizer = localizer = Localizer(self.agent, hybrid_map)
        localizer.start()
        limit = self.world.time + 120.0 + 3.0 * TIME_PER_METER * localizer.filter.loop_length
        self._run(lambda: localizer.done or self._stuck, limit, "finding out where it is")
        return localizer.node

    def give_up(self) -> GoReport:
        """The report of a robot that never knew where it was."""
        assert self._localizer is not None
        return self._report(
            reached=False,
            reason=self._localizer.reason or "found no place of the map in time",
            path=(),
            legs=(),
        )

    def drive(self, navigator: AnyNavigator, goal: int, truth: Truth) -> GoReport:
        """Drives to the goal, by other ways where one is shut, and scores where it stops."""
        guide = RecoveringNavigator(
            self.agent, navigator.map, navigator, localizes=isinstance(navigator, Navigator)
        )
        guide.go(goal)
        self._run(lambda: guide.done, math.inf, f"on the way to node {goal}")
        self._localizer = guide.localizer or self._localizer
        self.attempts, self.blocked = guide.attempts, guide.blocked
        pose = self.world.true_pose()
        place = Pose(*truth.nodes[goal]["pose"]) if goal in truth.nodes else None
        report = self._report(
            reached=guide.reached,
            reason=guide.reason if guide.reached else "; ".join(guide.reasons) or guide.reason,
            path=tuple(guide.path),
            legs=tuple(_leg_values(leg) for leg in guide.legs),
            error=None if place is None else place.distance_to(pose),
            turn=None if place is None else math.degrees(abs(wrap_angle(pose.heading - place.heading))),
        )
        guide.close()
        return report

    def _on_stuck(self, event: Stuck) -> None:
        self._stuck |= event.given_up

    def _run(
        self,
        done: Callable[[], bool],
        limit: float,
        message: str,
    ) -> None:
        """Ticks until it is done."""
        while not done() and self.world.time < limit:
            self.agent.tick()
            self.world.step()
            if self.world.time - self._told >= 1.0:
                self._told = self.world.time
                self.progress(Progress(self._told, 0, message))

    def _report(
        self,
        *,
        reached: bool,
        reason: str,
        path: tuple[int, ...],
        legs: tuple[dict[str, object], ...],
        error: float | None = None,
        turn: float | None = None,
    ) -> GoReport:
        localizer = self._localizer
        found = localizer is not None and localizer.node is not None
        return GoReport(
            reached=reached,
            lost=not reached or (error is not None and error > LOST_BEYOND),
            reason=reason,
            path=path,
            legs=legs,
            position_error_m=error,
            heading_error_deg=turn,
            distance_m=sum(float(str(leg["distance_m"])) for leg in legs),
            collisions=self.world.collisions(),
            sim_time_s=self.world.time,
            wall_time_s=time.perf_counter() - self._began,
            seed=self.request.seed,
            localized_node=localizer.node if localizer is not None else None,
            localized_after_m=localizer.length if localizer is not None and found else None,
        )


def learn(path: Path, report: GoReport, blocked: list[tuple[int, int, str]]) -> None:
    """Lets the map file learn from a trip: arcs driven to recognized ends, arcs found blocked."""
    with MapFile.resume(path) as file:
        changed = set()
        for leg in report.legs:
            key = (int(leg["from"]), int(leg["to"]), str(leg["kind"]))
            if leg["recognized"] and file.map.graph.has_edge(*key):
                foray = key[2] == "foray"
                file.map.record_traversal(*key, float(leg["distance_m"]), both_ways=not foray)
                changed.add(key)
                if not foray:
                    changed.add((key[1], key[0], other_side(key[2])))
        for key in blocked:
            file.map.block(*key)
            changed.add(key)
        file.update(file.map, arcs=sorted(key for key in changed if file.map.graph.has_edge(*key)))


def _leg_values(leg: LegDriven) -> dict[str, object]:
    return {
        "from": leg.source,
        "to": leg.target,
        "side": leg.side,
        "kind": leg.kind,
        "distance_m": leg.distance,
        "recognized": leg.recognized,
    }
