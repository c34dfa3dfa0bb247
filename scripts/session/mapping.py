"""Mapping as a job of a session: by one robot, into a map file or in memory."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from ...agent.events import CornerReached, LocalMapBuilt, LoopClosed, NodeCreated, Stuck
from ...agent.islands.mapper import IslandMapper
from ...agent.listener import Outcome
from ...maps.hybrid_map import HybridMap
from ...maps.local.local_map import LocalMap
from ...maps.storage.map_file import RUN
from ..errors import SessionError
from ..plain import plain, report_values
from .assembly import make_mapper
from .truth import is_known, node_truth, run_truth

if TYPE_CHECKING:
    from ...agent.goals import LocalSamples
    from ...agent.mapping.base import ArcKey
    from .map_files import MapWriter
    from .requests import MapRequest
    from .stage import Stage

CORRECT_WITHIN = 0.15
"""Meters between where a node is and where the robot says it is at it, up to which it is right."""
NO_CORNER_WITHIN = 30.0
"""Meters of driving without a corner after which a mapping is given up."""
_DRIVING = ("wall-following", "reactive-wall-following", "local-exploration", "position-correction")
"""The behaviors by which mappers drive."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapReport:
    """How a mapping went. Lengths in m; the fields are those of `tolman map --json`, and the `map`.

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
    map: HybridMap = field(compare=False, repr=False)

    def to_json(self) -> dict[str, Any]:
        """The fields but the map, as a dict of JSON values."""
        return report_values(self)


class Mapping:
    """A mapping by one robot: `begin` it, ask `watch` once a tick until it is over, take the `report`.

    `drive` does all of that by itself. map, mapper: what grows, and what makes it grow. outcome: how it
    ended, None while it is under way; `result` and `reason` both say why.
    """

    def __init__(
        self, stage: Stage, request: MapRequest, robot: int = 0, writer: MapWriter | None = None
    ) -> None:
        """writer: keeps it in a file. Raises: SessionError for what the profile cannot do."""
        self.stage, self.request, self.robot = stage, request, robot
        self.agent = stage.robot(robot)
        self.observer = stage.observers[robot]
        self.map = HybridMap(stage.map_meta(request)) if writer is None else writer.map
        stage.hybrid = self.map
        self.outcome: Outcome | None = None
        self.loop_correct: bool | None = None
        self._writer = writer
        self._corner_at = 0.0
        self._stuck = ""
        self._wall_time = 0.0
        bus = self.agent.bus
        self._subscriptions = [
            bus.subscribe(CornerReached, self._on_corner),
            bus.subscribe(Stuck, self._on_stuck),
            bus.subscribe(NodeCreated, self._on_node),
            bus.subscribe(LoopClosed, self._on_closed),
            bus.subscribe(LocalMapBuilt, self._on_local_map),
        ]
        self.mapper = make_mapper(stage.profile, request, self.agent, self.map, self)

    # --- driving -------------------------------------------------------------------------------------

    def drive(self) -> MapReport:
        """Maps until it is over, saves, and reports."""
        began = time.perf_counter()
        self.begin()
        self.stage.run(self.watch, stand=True)
        self._wall_time = time.perf_counter() - began
        self.finish()
        return self.report()

    def begin(self) -> None:
        """Sets out; or goes on, to the bit, where the file's last node left off."""
        self.observer.begin()
        if self._writer is not None and self._writer.state is not None:
            self._restore(self._writer)
            self.mapper.start()
            self.stage.world.step()
            self._tell(f"resumed after node {self.mapper.current}")
        else:
            self.mapper.start()
        self._corner_at = self.agent.odometry.travelled

    def watch(self) -> bool:
        """Whether it is over: the mapper is done, its time is up, or the robot gets nowhere."""
        if self.outcome is None:
            trouble = self._trouble()
            if self.mapper.done:
                self.outcome = Outcome(True, self.mapper.reason, self.mapper.reason)
            elif trouble:
                self.outcome = Outcome(trouble == "max time", trouble, trouble)
        return self.outcome is not None

    def _trouble(self) -> str:
        """Why it cannot go on; nothing if it can."""
        max_time = self.request.max_time
        if self._stuck:
            return f"stuck: {self._stuck}"
        if max_time is not None and self.stage.time >= max_time:
            return "max time"
        if self.agent.odometry.travelled - self._corner_at > NO_CORNER_WITHIN:
            return f"no corner within {NO_CORNER_WITHIN:.0f} m"
        return self.stage.trouble

    def cancel(self, reason: str = "cancelled") -> None:
        """Stops where the robot is; what was mapped stays."""
        if not self.mapper.done:
            self.mapper.stop(reason)
        if self.outcome is None:
            self.outcome = Outcome(False, reason=reason)
        self.release()

    def finish(self) -> None:
        """Completes the map: what is not committed is left out, the rest saved; the robot stops."""
        self.watch()
        self.agent.bus.deliver()
        self.note_current(closed=self.loop_correct is not None)
        graph = self.map.graph
        graph.remove_nodes_from([node for node in graph if node not in self.observer.nodes])
        if self._writer is not None:
            self._writer.finish({RUN: self._run_truth()})
        self.release()

    def release(self) -> None:
        """Hears and drives no more."""
        for subscription in self._subscriptions:
            subscription.cancel()
        for name in _DRIVING:
            if name in self.agent.behaviors:
                self.agent.stop(name)
        self.observer.end()

    # --- the map -------------------------------------------------------------------------------------

    def note_current(self, closed: bool) -> None:
        """The map says where the robot is now."""
        current = self.mapper.current
        known = current if current in self.map.graph else None
        arrival = None if known is None else self.request.side
        self.map.meta = replace(self.map.meta, current_node=known, arrival=arrival, loop_closed=closed)

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains a local map, with random numbers of its own so that a resumed run draws the same."""
        return LocalMap.build(
            samples.positions,
            samples.panorama_positions,
            samples.panoramas,
            self.stage.profile.local_map,
            np.random.default_rng(np.random.SeedSequence([self.request.seed, self.mapper.current])),
            entry_heading=entry_heading,
            entry_panorama=samples.panoramas[0] if len(samples.panoramas) else None,
        )

    def commit(self, node: int, corner: CornerReached) -> None:
        """A node is complete; where there is a file it is on disk when this returns."""
        self.observer.commit(node, corner)
        if self._writer is not None:
            self.map.meta = replace(self.map.meta, current_node=node, arrival=self.request.side)
            truth = plain(node_truth(self.observer.nodes[node], self.observer.track))
            rows = {**({node: truth} if truth else {}), RUN: self._run_truth()}
            self._writer.commit(node, plain(self._state()), rows)
            self.observer.track = []

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """No node was added but others may have changed, and those named were taken back."""
        for node in nodes:
            self.observer.nodes.pop(node, None)
        if self._writer is not None:
            self.note_current(closed=False)  # not complete: a resumed run goes on with the search
            state = {**self._state(), "track": self.observer.track}
            self._writer.rest(nodes, arcs, plain(state), {RUN: self._run_truth()})
        if isinstance(self.mapper, IslandMapper):
            self._tell(f"{self.mapper.forays} forays, {self.mapper.islands} islands")

    def _run_truth(self) -> dict[str, Any]:
        values: dict[str, Any] = plain(run_truth(self.observer.track, self.observer.pose))
        return values

    def _state(self) -> dict[str, Any]:
        """What a resumed mapping needs besides the map."""
        return {
            "mapper": self.mapper.state(),
            "odometry": self.agent.odometry.state(),
            **self.observer.state(),
            "driver": self.agent.driver,
            **({} if self.loop_correct is None else {"loop_correct": self.loop_correct}),
            "world": dict(self.stage.world.state()),
        }

    def _restore(self, writer: MapWriter) -> None:
        """Takes everything back to when the last node was committed, to the bit. Raises: SessionError."""
        state = writer.state
        try:
            self.stage.world.restore(state["world"])
            self.mapper.restore(state["mapper"])
            self.agent.odometry.restore(state["odometry"])
            self.observer.restore(state)
            self.agent.driver = state["driver"]
            self.loop_correct = state.get("loop_correct")
        except (TypeError, ValueError, LookupError, AttributeError) as fault:
            problem = "its run was kept by another version of tolman; map it afresh, with --force"
            raise SessionError(f"{self.request.output}: {problem}") from fault
        writer.committed = self.mapper.current

    # --- what happens --------------------------------------------------------------------------------

    def _on_corner(self, event: CornerReached) -> None:
        self._corner_at = self.agent.odometry.travelled

    def _on_node(self, event: NodeCreated) -> None:
        self._tell(f"node {event.node}: {event.corner} corner")

    def _on_closed(self, event: LoopClosed) -> None:
        distance = self.observer.met(event.met).distance_to(self.observer.nodes[event.node])
        right = abs(distance - abs(event.past)) <= CORRECT_WITHIN
        self.loop_correct = self.loop_correct is not False and right
        self._tell(f"loop closed at node {event.node}")

    def _on_stuck(self, event: Stuck) -> None:
        if event.given_up:
            self._stuck = event.reason

    def _on_local_map(self, event: LocalMapBuilt) -> None:
        self._corner_at = self.agent.odometry.travelled
        self._tell(f"local map of node {event.node}: {event.panoramas} panoramas")

    def _tell(self, message: str) -> None:
        self.stage.tell(self.map.graph.number_of_nodes(), message)

    # --- scoring -------------------------------------------------------------------------------------

    def report(self) -> MapReport:
        """Scores the map against the truth of this run."""
        graph, truth, world = self.map.graph, self.observer.nodes, self.stage.world
        pairs = [
            (data["distance"], truth[a].distance_to(truth[b]))
            for a, b, kind, data in graph.edges(keys=True, data=True)
            if kind == self.request.side
        ]
        mapped, true = sum(pair[0] for pair in pairs), sum(pair[1] for pair in pairs)
        found: dict[str, Any] = {}
        if isinstance(self.mapper, IslandMapper):
            found = {name: getattr(self.mapper, name) for name in ("islands", "forays", "scouted")}
        return MapReport(
            nodes=graph.number_of_nodes(),
            arcs=graph.number_of_edges(),
            local_maps=sum(data["local_map"] is not None for _, data in graph.nodes(data=True)),
            loop_closed=self.loop_correct is not None,
            loop_correct=self.loop_correct if is_known(self.observer.pose) else None,
            reason="" if self.outcome is None else self.outcome.reason,
            loop_distance_m=mapped,
            true_loop_distance_m=true,
            position_error_m=abs(mapped - true),
            largest_arc_error_m=max((abs(a - b) for a, b in pairs), default=0.0),
            path_integration_error_m=self.observer.raw.pose.distance_to(self.observer.pose),
            collisions=world.collisions(self.robot),
            sim_time_s=world.time,
            wall_time_s=self._wall_time,
            real_time_factor=world.time / self._wall_time if self._wall_time > 0 else 0.0,
            seed=self.request.seed,
            profile=self.request.profile,
            noise=self.request.noise,
            world=world.spec.name,
            version=version("tolman"),
            map=self.map,
            **found,
        )
