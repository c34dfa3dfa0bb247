"""Mapping: from corners and samples to nodes, arcs and local maps, until a loop is closed (section 3.4).

The mapper drives nothing itself. It starts behaviors, listens to what they report and grows a hybrid map:

    follow the wall -> corner -> (back at a known one? then confirm) -> new node and arc
    -> explore locally -> train the local map -> come to the corner again -> commit -> follow the wall ...
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import Percept, wrap_angle
from ..boundary.loop_closing import CornerObservation, Finding, LoopDetector
from ..boundary.trace import BEND, BoundaryTrace, ClosingConfig
from ..estimation.wall_segments import WallSegmentMeter
from ..estimation.wheel_calibration import SETTLED, MismatchEstimate
from ..events import (
    ArcAdded,
    BehaviorFinished,
    CornerReached,
    LocalMapBuilt,
    LoopClosed,
    NodeCommitted,
    NodeCreated,
    WallMet,
)
from ..goals import ExploreLocally, Follow, FollowFrom, GoAlong, Leg, LocalSamples, ReacquireCorner
from ..local_goals import walls_at

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...maps.hybrid_map import HybridMap
    from ...maps.local.local_map import LocalMap
    from ..agent import Agent
    from ..behavior import Context

_START_AT = {"concave": FollowFrom.CONCAVE, "convex": FollowFrom.CONVEX, BEND: FollowFrom.WALL}
_NAMED = {"concave": "concave", "convex": "convex", BEND: "none"}
"""What the map calls a node's corner."""
_LEAST_PROBE, _MOST_PROBE = 0.25, 0.6
"""Meters of a wall that are driven twice to tell what is the wall's bending and what the wheels'."""
_ROUNDS_OF_BENDS = 1.8
"""Rounds after which a boundary without a corner is given up."""
_STRATEGIES = {"rows": ("rows", "rows"), "columns": ("columns", "columns"), "alternate": ("rows", "columns")}


class Phase(Enum):
    """What mapping is waiting for."""

    FOLLOW = "follow the wall"
    EXPLORE = "explore around the node"
    RETURN = "come to the corner again"
    CONFIRM = "confirm the loop"
    PROBE = "drive there and back along the wall"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class MappingConfig:
    """Settings of mapping.

    side: of the wall. local_maps: whether to explore around nodes. strategy: "rows", "columns" or
    "alternate". max_nodes: end after so many, None for no limit. most_rounds: given up after so many times
    round the boundary. wall_distance: at which walls are followed (m). learn_mismatch: of the wheels, along
    walls. come_back: to the corner by its wall, after exploring. bend_gate: standard deviation (m) of
    where path integration finds a place again, up to which a loop is closed at a bend.
    """

    side: str = "right"
    local_maps: bool = True
    strategy: str = "alternate"
    max_nodes: int | None = None
    most_rounds: float = 3.0
    wall_distance: float = 0.057
    learn_mismatch: bool = True
    come_back: bool = True
    bend_gate: float = 0.08
    closing: ClosingConfig = field(default_factory=ClosingConfig)


class Mapper:
    """Builds a `HybridMap` with an `Agent` that has wall following, local exploration, position correction.

    build: makes a `LocalMap` of the samples and the entry heading (rad, map frame). on_commit: called with
    each node that is complete, while the robot stands at it, and when it met it first. Done when `reason` is
    set. The map frame has node 0 at the origin, its x axis along node 0's entry heading; `heading` is that of
    this boundary's first wall (rad) in it, 0 unless the map has other boundaries already.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        build: Callable[[LocalSamples, float], LocalMap],
        config: MappingConfig = MappingConfig(),
        on_commit: Callable[[int, float], None] = lambda node, met_at: None,
    ) -> None:
        """Subscribes to the agent's events; `begin` starts the drive, `drive_on` goes on after `restore`."""
        self.agent = agent
        self.map = hybrid_map
        self.config = config
        self.circuit = LoopDetector(config.closing)
        track = agent.robot.geometry.track
        self.meter = WallSegmentMeter(agent.odometry, track, config.learn_mismatch)
        self.phase = Phase.FOLLOW
        self.reason = ""
        self.current = -1
        self.heading = 0.0
        self._build = build
        self._on_commit = on_commit
        self._met_at = 0.0
        self._corner: CornerReached | None = None
        self._probed: CornerReached | None = None
        agent.bus.subscribe(CornerReached, self._on_corner)
        agent.bus.subscribe(WallMet, self._on_wall)
        agent.bus.subscribe(BehaviorFinished, self._on_finished)

    def begin(self) -> None:
        """Starts following the wall from wherever the robot stands."""
        self.agent.start("wall-following", Follow(self.config.side))

    def update(self, percept: Percept, context: Context) -> None:
        """Nothing to do every tick: everything comes by events."""

    @property
    def trace(self) -> BoundaryTrace:
        """The boundary that is being followed."""
        return self.circuit.trace

    @property
    def mismatch(self) -> MismatchEstimate:
        """What is known of the wheels."""
        return self.meter.mismatch

    @property
    def done(self) -> bool:
        """Whether mapping has ended; `reason` says why."""
        return bool(self.reason)

    @property
    def nodes(self) -> tuple[int, ...]:
        """The nodes it has added, in the order of the boundary."""
        return tuple(self.circuit.node_of[index] for index in sorted(self.circuit.node_of))

    def index(self, node: int) -> int:
        """Which corner of the trace a node is. Raises: KeyError for a node that is not of this boundary."""
        return {known: index for index, known in self.circuit.node_of.items()}[node]

    # --- state -----

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly, as JSON; to be taken in `on_commit`."""
        assert self._corner is not None
        return {
            **self.circuit.state(),
            "current": self.current,
            "corner": asdict(self._corner),
            "wall": None if self.meter.wall is None else asdict(self.meter.wall),
            "mismatch": [self.mismatch.value, self.mismatch.variance],
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`; `drive_on` then goes on from there."""
        self.circuit.restore(state)
        self.current = int(state["current"])
        self._corner = CornerReached(**state["corner"])
        self.meter.met(None if state["wall"] is None else WallMet(**state["wall"]))
        self.mismatch.value, self.mismatch.variance = state["mismatch"]
        self.mismatch.apply(self.agent.odometry)

    # --- events --------------------------------------------------------------------------------------

    def _on_wall(self, event: WallMet) -> None:
        self.meter.met(event)
        if self.phase in (Phase.FOLLOW, Phase.CONFIRM) and self._corner is not None:
            turn = wrap_angle(event.heading - self._corner.heading)
            self._corner = None
            self.trace.turned(turn)
            node = self.circuit.node_of.get(len(self.trace.corners) - 1)
            if node is not None:
                self.map.graph.nodes[node]["turn"] = turn

    def _on_corner(self, event: CornerReached) -> None:
        if self.phase not in (Phase.FOLLOW, Phase.CONFIRM):
            return
        if event.kind == BEND and self.meter.unsure and event.path_length >= _LEAST_PROBE:
            self._probe(event)
        else:
            self._judge(event)

    def _judge(self, event: CornerReached) -> None:
        """Takes a corner or bend for what it is: none, a new one or one known."""
        arrived = self.meter.arrive(event)
        if arrived is None:
            return
        event, way = arrived
        self._corner = event
        loop = sum(corner.length for corner in self.trace.corners)
        bends = self.meter.place_deviation(loop) <= self.config.bend_gate
        judgement = self.circuit.reach(event, way, bends)
        self._admit(judgement.rejected)
        if judgement.finding is Finding.CLOSED:
            self._close()
        elif judgement.finding is Finding.MAYBE_KNOWN:
            self.phase = Phase.CONFIRM
            if judgement.rejected:
                # Nodes were committed: a resumed run begins here anew, and so does this one.
                self.agent.stop("wall-following")
                self.drive_on()
        elif self._rounds() > _ROUNDS_OF_BENDS and all(each.kind == BEND for each in self.trace.corners):
            self.stop(
                "ambiguous: no corner on this boundary, and nothing tells one of its bends from another"
            )
        elif self._rounds() > self.config.most_rounds:
            self.stop(f"{self.config.most_rounds:.0f} rounds without recognizing a corner")
        else:
            self._add_node(len(self.trace.corners) - 1, event)
            self._explore()

    def _rounds(self) -> float:
        """How often the boundary has turned right round since the first corner."""
        poses = self.trace.poses()
        return abs(poses[-1].heading - poses[0].heading) / math.tau

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior == "local-exploration" and self.phase is Phase.EXPLORE:
            self._keep_samples(event.result)
            if self.config.come_back:
                self._return()
            else:
                self._commit()
        elif event.behavior == "position-correction" and self.phase is Phase.RETURN:
            if isinstance(event.result, CornerReached):
                self._corner = event.result
            self._commit()
        elif event.behavior == "go-to-node" and self.phase is Phase.PROBE:
            self._probed_wall(event.succeeded)

    # --- steps ---------------------------------------------------------------------------------------

    def _add_node(self, index: int, event: CornerReached) -> None:
        """Adds the node of a corner of the trace, and the arcs that join it to the one before."""
        heading = wrap_angle(self.heading + self.trace.poses()[index].heading)
        turn = self.trace.corners[index].turn or 0.0
        node = self.map.add_node(corner=_NAMED[event.kind], turn=turn, entry_heading=heading)
        previous, self.current = self.current, node
        self.circuit.node_of[index] = node
        self._met_at = event.time
        self.agent.bus.publish(
            NodeCreated(time=self.agent.context.time, node=node, corner=event.kind, met_at=event.time)
        )
        if previous >= 0:
            self._add_arc(previous, node, event.path_length)

    def _probe(self, event: CornerReached) -> None:
        """Drives back along the wall and here again: its bending is undone, what the wheels do is doubled."""
        self.agent.stop("wall-following")
        self.phase, self._probed = Phase.PROBE, event
        length = min(event.path_length - SETTLED, _MOST_PROBE)
        other = "left" if self.config.side == "right" else "right"
        there = Leg(-1, -1, other, length, "none", math.pi, FollowFrom.WALL)
        back = Leg(-1, -1, self.config.side, length, "none", math.pi, FollowFrom.WALL)
        self.agent.start("go-to-node", GoAlong((there, back)))

    def _probed_wall(self, succeeded: bool) -> None:
        """Judges the bend anew, now that the wheels are known."""
        event, self._probed = self._probed, None
        assert event is not None
        if not succeeded:
            self.stop("no corner tells where this boundary begins, and its wall could not be driven twice")
            return
        length = min(event.path_length - SETTLED, _MOST_PROBE)
        turned = wrap_angle(self.agent.odometry.heading - event.heading)
        self.meter.calibrate(turned, 2.0 * length, event.path_length)
        self.phase = Phase.FOLLOW
        self._judge(replace(event, heading=wrap_angle(self.agent.odometry.heading)))
        waits = self.phase in (Phase.FOLLOW, Phase.CONFIRM)
        if waits and not self.agent.is_active("wall-following"):
            self.meter.leave()
            self.agent.start("wall-following", Follow(self.config.side, FollowFrom.WALL))

    def _explore(self) -> None:
        self.agent.stop("wall-following")
        if not self.config.local_maps:
            self._commit()
            return
        self.phase = Phase.EXPLORE
        strategy = _STRATEGIES[self.config.strategy][self.current % 2]
        self.agent.start("local-exploration", self._exploration(strategy))

    def _exploration(self, strategy: str) -> ExploreLocally:
        """What to explore, and what is known already: the wall it came along and, if square, the next."""
        assert self._corner is not None
        distance = self.config.wall_distance
        bend = self._corner.kind == BEND
        square = not bend and (self.trace.is_right_angled or len(self.trace.corners) < 3)
        walls = walls_at(self.config.side, self._corner.kind, square=square, distance=distance)
        heading = wrap_angle(self.agent.odometry.heading - self._corner.heading)
        edge = (-distance, -distance if self.config.side == "right" else distance)
        points = (edge,) if self._corner.kind == "convex" else ()
        return ExploreLocally(
            strategy, heading, walls, square, self._corner.kind, points, self.agent.odometry.drift_rate
        )

    def _add_arc(self, source: int, target: int, distance: float) -> None:
        side = self.config.side
        self.map.add_arc(source, target, side=side, distance=distance, variance=_variance(distance))
        self.agent.bus.publish(
            ArcAdded(time=self.agent.context.time, source=source, target=target, side=side, distance=distance)
        )

    def _keep_samples(self, samples: Any) -> None:
        node = self.current
        if not isinstance(samples, LocalSamples) or len(samples.positions) == 0:
            return
        heading = self.map.graph.nodes[node]["entry_heading"]
        self.map.graph.nodes[node]["local_map"] = self._build(samples, heading)
        self.agent.bus.publish(
            LocalMapBuilt(
                time=self.agent.context.time,
                node=node,
                positions=len(samples.positions),
                panoramas=len(samples.panoramas),
            )
        )

    def _return(self) -> None:
        assert self._corner is not None
        if self._corner.kind == BEND:
            self._commit()
            return
        self.phase = Phase.RETURN
        length = self.trace.corners[-1].length or self._corner.path_length
        if len(self.trace.corners) > 1 and self.trace.corners[-2].kind == "convex":
            # The wall begins only that much after the node before, and its end is seen blurred.
            length -= self.config.wall_distance + 0.015
        self.agent.start("position-correction", ReacquireCorner(self.config.side, self._corner.kind, length))

    def _commit(self) -> None:
        """The node is complete: says so, and drives on."""
        self.phase = Phase.FOLLOW
        self._on_commit(self.current, self._met_at)
        self.agent.bus.publish(NodeCommitted(time=self.agent.context.time, node=self.current))
        if self.config.max_nodes is not None and len(self.circuit.node_of) >= self.config.max_nodes:
            self.stop("max nodes")
        else:
            self.drive_on()

    def drive_on(self) -> None:
        """Follows the wall from the corner the robot stands at."""
        assert self._corner is not None
        self.meter.leave()
        start = _START_AT[self._corner.kind]
        self.agent.start("wall-following", Follow(self.config.side, start, self._corner.turn))

    def _admit(self, rejected: tuple[CornerObservation, ...]) -> None:
        """They were other places after all: what was taken for known corners becomes nodes, unexplored."""
        for met in rejected:
            self._add_node(met.index, met.event)
            self._on_commit(self.current, self._met_at)
            self.agent.bus.publish(NodeCommitted(time=self.agent.context.time, node=self.current))
        if rejected:
            self.phase = Phase.FOLLOW

    def _close(self) -> None:
        circuit = self.circuit
        closing = circuit.closing
        assert closing is not None
        first, met_at = circuit.node_of[circuit.candidate], closing.mets[0].event.time
        self._add_arc(self.current, first, circuit.closing_length)
        for source, target, length in circuit.driven_again():
            self.map.record_traversal(source, target, self.config.side, length)
        self.current = circuit.here
        self.agent.bus.publish(
            LoopClosed(time=self.agent.context.time, node=first, met_at=met_at, past=closing.past)
        )
        self.stop("loop closed")

    def stop(self, reason: str) -> None:
        """Ends mapping: no corner becomes a node any more."""
        self.reason = reason
        self.phase = Phase.DONE
        self.agent.stop("wall-following")


def _variance(distance: float) -> float:
    """Of an arc's length (m^2): encoder noise of 10 % uniform a millimeter, and a corner's 1 mm."""
    return 1e-6 + distance * 1.6e-6
