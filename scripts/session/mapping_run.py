"""The former way to run a mapping, for experiments until they use `mapping.Mapping` on a `Simulation`."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from ...agent import Agent, PathIntegrator
from ...agent.events import CornerReached, LocalMapBuilt, LoopClosed, NodeCreated, Stuck
from ...agent.goals import LocalSamples
from ...agent.islands.mapper import IslandMapper
from ...agent.mapping.base import AnyMapper, ArcKey
from ...maps.hybrid_map import HybridMap
from ...maps.local.local_map import LocalMap
from ...maps.meta import MapMeta
from ...maps.storage.map_file import RUN, MapFile
from ...world import World
from ...world.robot import Pose
from ..plain import plain
from .assembly import make_agent
from .mapping import MapReport
from .profiles import Profile, make_mapper
from .requests import MapRequest, Progress, SessionError
from .truth import node_truth, run_truth

CORRECT_WITHIN = 0.15
"""Meters between where a node is and where the robot says it is at it, up to which it is right."""
NO_CORNER_WITHIN = 30.0
"""Meters of driving without a corner after which a mapping is given up."""


def open_map_file(request: MapRequest, world: World) -> MapFile:
    """The file that a mapping writes: a new one, or one to go on with. Raises: MapError, SessionError."""
    if request.resume:
        assert request.output is not None
        file = MapFile.resume(request.output)
        why = _why_not_resumed(request, world, file.map.meta)
        if why:
            file.seal()
            raise SessionError(f"{request.output}: {why}")
        return file
    meta = MapMeta(
        world=world.spec.name,
        world_digest=world.spec.digest,
        profile=request.profile,
        side=request.side,
        seed=request.seed,
        noise=request.noise,
        versions={"tolman": version("tolman")},
        geometry=world.robots[0].geometry.name,
        scalars={
            "noise_scale": request.noise_scale,
            "robot_model": request.model,
            **({"islands": True} if request.islands else {}),
        },
    )
    assert request.output is not None
    return MapFile.create(request.output, meta, force=request.force)


def _why_not_resumed(request: MapRequest, world: World, meta: MapMeta) -> str:
    """What keeps a map from being gone on with as asked; nothing if it can be."""
    if meta.loop_closed:
        return "this mapping is complete, its loop is closed; --force begins a new one"
    if meta.world_digest != world.spec.digest:
        return f"a map of {meta.world}, not of {world.spec.name}: cannot be resumed there"
    began = {
        "side": (meta.side, request.side),
        "seed": (meta.seed, request.seed),
        "noise": (meta.noise, request.noise),
        "profile": (meta.profile, request.profile),
        "noise-scale": (meta.scalars.get("noise_scale"), request.noise_scale),
        "robot-model": (meta.scalars.get("robot_model"), request.model),
    }
    if bool(meta.scalars.get("islands")) is not request.islands:
        return f"begun with{'out' if request.islands else ''} --islands: resume it in the same way"
    for name, (then, now) in began.items():
        if then != now:
            return f"begun with --{name} {then}, not {now}: resume it with the same"
    return ""


class MappingRun:
    """One mapping from start to report. Knows the truth; the agent does not."""

    def __init__(
        self,
        request: MapRequest,
        world: World,
        file: MapFile,
        settings: dict[str, Any],
        profile: Profile,
        progress: Callable[[Progress], None],
    ) -> None:
        """Wires everything; `drive` runs it."""
        self.request, self.world, self.file, self.progress = request, world, file, progress
        self.profile = profile
        self.agent: Agent = make_agent(request, world, settings, profile=profile)
        self._met: dict[int, Pose] = {}
        bus = self.agent.bus
        bus.subscribe(CornerReached, self._on_corner)
        bus.subscribe(Stuck, self._on_stuck)
        bus.subscribe(NodeCreated, self._on_node)
        bus.subscribe(LoopClosed, self._on_closed)
        bus.subscribe(LocalMapBuilt, self._on_local_map)
        self.map = HybridMap(file.map.meta) if not request.resume else file.map
        self.mapper: AnyMapper = make_mapper(profile, request, self.agent, self.map, self)
        self.raw = PathIntegrator(world.robots[0].geometry, world.true_pose())
        self.truth: dict[int, Pose] = {}
        self._track: list[tuple[float, float]] = []
        self._committed: int | None = None
        self._loop_correct: bool | None = None
        self._travelled_at_corner = 0.0
        self._stuck: str | None = None

    # --- driving -------------------------------------------------------------------------------------

    def drive(self) -> None:
        """Runs until the mapper is done, or time is up."""
        began = time.perf_counter()
        if self.request.resume and self.file.state is not None:
            self._restore()
        else:
            self.mapper.start()
        reason = self._loop()
        self.wall_time = time.perf_counter() - began
        self.reason = self.mapper.reason or reason
        self._finish()

    def _loop(self) -> str:
        agent, world, mapper, raw = self.agent, self.world, self.mapper, self.raw
        max_time = self.request.max_time
        while True:
            agent.tick()
            raw.update(world.robots[0].sense().encoders)
            if mapper.done:
                return mapper.reason
            if self._stuck is not None:
                return f"stuck: {self._stuck}"
            if max_time is not None and world.time >= max_time:
                return "max time"
            if agent.odometry.travelled - self._travelled_at_corner > NO_CORNER_WITHIN:
                return f"no corner within {NO_CORNER_WITHIN:.0f} m"
            world.step()
            self._trace()

    def _trace(self) -> None:
        pose = self.world.true_pose()
        if not self._track or abs(pose.x - self._track[-1][0]) + abs(pose.y - self._track[-1][1]) > 0.01:
            self._track.append((pose.x, pose.y))

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains a local map, with random numbers of its own so that a resumed run draws the same."""
        return LocalMap.build(
            samples.positions,
            samples.panorama_positions,
            samples.panoramas,
            self.profile.local_map,
            np.random.default_rng(np.random.SeedSequence([self.request.seed, self.mapper.current])),
            entry_heading=entry_heading,
            entry_panorama=samples.panoramas[0] if len(samples.panoramas) else None,
        )

    # --- truth and saving ----------------------------------------------------------------------------

    def _on_corner(self, event: CornerReached) -> None:
        self._true_pose(event)
        self._travelled_at_corner = self.agent.odometry.travelled

    def _true_pose(self, corner: CornerReached) -> Pose:
        """Where the robot truly met a corner, turned by what it believes to be askew to the wall.

        It is noted in the tick in which the corner is met, whoever hears of it first.
        """
        if corner.number not in self._met:
            pose = self.world.true_pose()
            skew = self.agent.odometry.heading - corner.heading
            self._met[corner.number] = Pose(pose.x, pose.y, pose.heading - skew)
        return self._met[corner.number]

    def _on_node(self, event: NodeCreated) -> None:
        self.truth[event.node] = self._met[event.met]
        self._report_progress(f"node {event.node}: {event.corner} corner")

    def _on_closed(self, event: LoopClosed) -> None:
        distance = self._met[event.met].distance_to(self.truth[event.node])
        right = abs(distance - abs(event.past)) <= CORRECT_WITHIN
        self._loop_correct = self._loop_correct is not False and right
        self._report_progress(f"loop closed at node {event.node}")

    def _on_stuck(self, event: Stuck) -> None:
        if event.given_up:
            self._stuck = event.reason

    def _on_local_map(self, event: LocalMapBuilt) -> None:
        self._travelled_at_corner = self.agent.odometry.travelled
        self._report_progress(f"local map of node {event.node}: {event.panoramas} panoramas")

    def _report_progress(self, message: str) -> None:
        self.progress(Progress(self.world.time, self.map.graph.number_of_nodes(), message))

    def commit(self, node: int, corner: CornerReached) -> None:
        """Saves a complete node with all that a resumed run needs; it is on disk when this returns."""
        self.truth[node] = self._true_pose(corner)
        nodes = [node] if self._committed is None else [self._committed, node]
        graph = self.map.graph
        arcs = [*graph.in_edges(node, keys=True), *graph.out_edges(node, keys=True)]
        self.map.meta = replace(self.map.meta, current_node=node, arrival=self.request.side)
        truth = {node: node_truth(self.truth[node], self._track), RUN: self._run_truth()}
        plain_truth = {key: plain(value) for key, value in truth.items()}
        self.file.update(self.map, nodes, arcs, state=plain(self._state()), truth=plain_truth)
        self._committed = node
        self._track = []

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Saves what changed while no node was added, and forgets nodes and arcs that were taken back."""
        for node in nodes:
            self.truth.pop(node, None)
        if self._committed is not None and self._committed in self.map.graph:
            nodes = [*nodes, self._committed]
        self._note_current(closed=False)  # not complete: a resumed run goes on with the search
        self.file.update(
            self.map,
            nodes,
            [*arcs, *self.map.graph.edges(keys=True)],
            state=plain({**self._state(), "track": self._track}),
            truth={RUN: plain(self._run_truth())},
        )
        if isinstance(self.mapper, IslandMapper):
            self._report_progress(f"{self.mapper.forays} forays, {self.mapper.islands} islands")

    def _note_current(self, closed: bool) -> None:
        current = self.mapper.current
        known = current if current in self.map.graph else None
        arrival = None if known is None else self.request.side
        self.map.meta = replace(self.map.meta, current_node=known, arrival=arrival, loop_closed=closed)

    def _run_truth(self) -> dict[str, Any]:
        pose = self.world.true_pose()
        return {
            **run_truth(self._track),
            "pose": [pose.x, pose.y, pose.heading],
        }

    def _state(self) -> dict[str, Any]:
        return {
            "mapper": self.mapper.state(),
            "odometry": self.agent.odometry.state(),
            "raw": self.raw.state(),
            "truth": {str(node): [p.x, p.y, p.heading] for node, p in self.truth.items()},
            "driver": self.agent.driver,
            **({} if self._loop_correct is None else {"loop_correct": self._loop_correct}),
            "world": dict(self.world.state()),
        }

    def _restore(self) -> None:
        """Goes on where the last committed node left off, to the bit."""
        state: Any = self.file.state
        self.world.restore(state["world"])
        self.mapper.restore(state["mapper"])
        self.agent.odometry.restore(state["odometry"])
        self.raw.restore(state["raw"])
        self.agent.driver = state["driver"]
        self._loop_correct = state.get("loop_correct")
        self._track = [(x, y) for x, y in state.get("track", ())]
        self.truth = {int(node): Pose(*pose) for node, pose in state["truth"].items()}
        self._committed = self.mapper.current
        self.mapper.start()
        self.world.step()
        self._report_progress(f"resumed after node {self.mapper.current}")

    def _finish(self) -> None:
        self.agent.bus.deliver()
        self._note_current(closed=self._loop_correct is not None)
        graph = self.map.graph
        uncommitted = [node for node in graph if node not in self.truth]
        graph.remove_nodes_from(uncommitted)
        self.file.update(
            self.map,
            list(graph),
            list(graph.edges(keys=True)),
            truth={RUN: plain(self._run_truth())},
        )
        self.file.seal()

    # --- scoring -------------------------------------------------------------------------------------

    def report(self) -> MapReport:
        """Scores the map against the truth of this run."""
        graph, side = self.map.graph, self.request.side
        pairs = [
            (data["distance"], self.truth[a].distance_to(self.truth[b]))
            for a, b, kind, data in graph.edges(keys=True, data=True)
            if kind == side
        ]
        mapped, true = sum(pair[0] for pair in pairs), sum(pair[1] for pair in pairs)
        sim_time = self.world.time
        return MapReport(
            nodes=graph.number_of_nodes(),
            arcs=graph.number_of_edges(),
            local_maps=sum(data["local_map"] is not None for _, data in graph.nodes(data=True)),
            loop_closed=self._loop_correct is not None,
            loop_correct=self._loop_correct,
            reason=self.reason,
            loop_distance_m=mapped,
            true_loop_distance_m=true,
            position_error_m=abs(mapped - true),
            largest_arc_error_m=max((abs(a - b) for a, b in pairs), default=0.0),
            path_integration_error_m=self.raw.pose.distance_to(self.world.true_pose()),
            collisions=self.world.collisions(),
            sim_time_s=sim_time,
            wall_time_s=self.wall_time,
            real_time_factor=sim_time / self.wall_time if self.wall_time > 0 else 0.0,
            seed=self.request.seed,
            profile=self.request.profile,
            noise=self.request.noise,
            world=self.world.spec.name,
            version=version("tolman"),
            map=self.map,
            **_found(self.mapper),
        )


def _found(mapper: AnyMapper) -> dict[str, Any]:
    """What the search for islands came to, if there was one."""
    if not isinstance(mapper, IslandMapper):
        return {}
    return {"islands": mapper.islands, "forays": mapper.forays, "scouted": mapper.scouted}
