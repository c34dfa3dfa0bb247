"""Mapping by corners: each is a node, until those met tell that the boundary has come round (section 3.4).

follow the wall -> corner -> (back at a known one? then confirm) -> new node and arc
-> explore locally -> train the local map -> come to the corner again -> commit -> follow the wall ...
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import wrap_angle
from ..boundary.loop_closing import CornerObservation, Finding, LoopDetector
from ..boundary.trace import BEND, ClosingConfig
from ..codec import reinstate, snapshot
from ..estimation.wall_segments import WallSegmentMeter
from ..estimation.wheel_calibration import MismatchEstimate
from ..events import BehaviorFinished, CornerReached, LoopClosed, WallMet
from ..goals import START_AT, ExploreLocally, Follow, FollowFrom, ReacquireCorner
from ..walls import WALL_DISTANCE, away_from, walls_at
from .base import BaseMapper, MapSink, NodeSettings
from .probing import LEAST_PROBE, WallProbe

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent
    from ..listener import Outcome

_NAMED = {"concave": "concave", "convex": "convex", BEND: "none"}
"""What the map calls a node's corner."""
_ROUNDS_OF_BENDS = 1.8
"""Rounds after which a boundary without a corner is given up."""
_KEPT = ("wall", "mismatch")


class Phase(Enum):
    """What mapping is waiting for."""

    FOLLOW = "follow the wall"
    EXPLORE = "explore around the node"
    RETURN = "come to the corner again"
    CONFIRM = "confirm the loop"
    PROBE = "drive there and back along the wall"


@dataclass(frozen=True, slots=True)
class MappingConfig(NodeSettings):
    """Settings of mapping by corners, beside those of every mapper.

    most_rounds: given up after so many times round the boundary. wall_distance: at which walls are followed
    (m). learn_mismatch: of the wheels, along walls. come_back: to the corner by its wall, after exploring.
    bend_gate: standard deviation (m) of where path integration finds a place again, up to which a loop is
    closed at a bend.
    """

    most_rounds: float = 3.0
    wall_distance: float = WALL_DISTANCE
    learn_mismatch: bool = True
    come_back: bool = True
    bend_gate: float = 0.08
    closing: ClosingConfig = field(default_factory=ClosingConfig)


class Mapper(BaseMapper):
    """Builds a `HybridMap` with an `Agent` that has wall following, local exploration, position correction.

    The map frame has node 0 at the origin, its x axis along node 0's entry heading; `heading` is that of this
    boundary's first wall (rad) in it, 0 unless the map has other boundaries already.
    """

    behaviors = ("wall-following", "local-exploration", "position-correction", "go-to-node")
    kept = (*BaseMapper.kept, "_corner")

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        sink: MapSink,
        config: MappingConfig = MappingConfig(),
        keeps_out: Callable[[CornerReached], bool] = lambda corner: False,
    ) -> None:
        """Listens to the agent; `start` starts the drive.

        keeps_out: asked of each corner or bend that would be taken; True keeps it out of the map.
        """
        super().__init__(agent, hybrid_map, sink, config)
        self.config = config
        self.loop = LoopDetector(config.closing)
        track = agent.robot.geometry.track
        self.meter = WallSegmentMeter(agent.odometry, track, config.learn_mismatch)
        self.phase = Phase.FOLLOW
        self.heading = 0.0
        self._keeps_out = keeps_out
        self._corner: CornerReached | None = None
        self._probe = WallProbe(agent, config.side, self.meter, self._on_probed)
        self.listen(CornerReached, self._on_corner)
        self.listen(WallMet, self._on_wall)
        self.listen(BehaviorFinished, self._on_finished)

    def start(self) -> None:
        """Follows the wall from wherever the robot stands, after `restore` from the corner it stands at."""
        super().start()
        if self._corner is None:
            self.agent.start("wall-following", Follow(self.config.side))
        else:
            self._go_on()

    @property
    def listening(self) -> bool:
        """Whether a corner met now is taken for one of the boundary."""
        return not self.done and self.phase in (Phase.FOLLOW, Phase.CONFIRM)

    @property
    def nodes(self) -> tuple[int, ...]:
        """The nodes it has added, in the order of the boundary."""
        return tuple(self.loop.node_of[index] for index in sorted(self.loop.node_of))

    def index(self, node: int) -> int:
        """Which corner of the trace a node is. Raises: KeyError for a node that is not of this boundary."""
        return {known: index for index, known in self.loop.node_of.items()}[node]

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it where it is."""
        super().stop(reason)
        self._probe.stop()

    def close(self) -> None:
        """Hears no more."""
        super().close()
        self._probe.close()

    # --- state -----

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly; to be taken while a node is committed."""
        assert self._corner is not None
        return {
            **super().state(),
            **self.loop.state(),
            **snapshot(self.meter, _KEPT),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        super().restore(state)
        self.loop.restore(state)
        reinstate(self.meter, _KEPT, state, MismatchEstimate)
        self.meter.mismatch.apply(self.agent.odometry)

    # --- events --------------------------------------------------------------------------------------

    def _on_wall(self, event: WallMet) -> None:
        self.meter.wall = event
        if self.listening and self._corner is not None:
            turn = wrap_angle(event.heading - self._corner.heading)
            self._corner = None
            self.loop.trace.turned(turn)
            node = self.loop.node_of.get(len(self.loop.trace.corners) - 1)
            if node is not None:
                self.map.graph.nodes[node]["turn"] = turn

    def _on_corner(self, event: CornerReached) -> None:
        if not self.listening or self._keeps_out(event):
            return
        if event.kind == BEND and self.meter.unsure and event.path_length >= LEAST_PROBE:
            self.agent.stop("wall-following")
            self.phase = Phase.PROBE
            self._probe.probe(event)
        else:
            self._judge(event)

    def _judge(self, event: CornerReached) -> None:
        """Takes a corner or bend for what it is: none, a new one or one known."""
        arrived = self.meter.arrive(event)
        if arrived is None:
            return
        event, way = arrived
        self._corner = event
        length = sum(corner.length for corner in self.loop.trace.corners)
        bends = self.meter.place_deviation(length) <= self.config.bend_gate
        judgement = self.loop.reach(event, way, bends)
        self._admit(judgement.rejected)
        if judgement.finding is Finding.CLOSED:
            self._close()
        elif judgement.finding is Finding.MAYBE_KNOWN:
            self.phase = Phase.CONFIRM
            if judgement.rejected:
                # Nodes were committed: a resumed run begins again here, and so does this one.
                self.agent.stop("wall-following")
                self._go_on()
        elif self._rounds() > _ROUNDS_OF_BENDS and all(each.kind == BEND for each in self.loop.trace.corners):
            self._end(
                False,
                "ambiguous: no corner on this boundary, and nothing tells one of its bends from another",
            )
        elif self._rounds() > self.config.most_rounds:
            self._end(False, f"{self.config.most_rounds:.0f} rounds without recognizing a corner")
        else:
            self._add_node(len(self.loop.trace.corners) - 1, event)
            self._explore()

    def _rounds(self) -> float:
        """How often the boundary has turned right round since the first corner."""
        poses = self.loop.trace.poses()
        return abs(poses[-1].heading - poses[0].heading) / math.tau

    def _on_finished(self, event: BehaviorFinished) -> None:
        if self.done:
            return
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

    # --- steps ---------------------------------------------------------------------------------------

    def _add_node(self, index: int, event: CornerReached) -> None:
        """Adds the node of a corner of the trace, and the arcs that join it to the one before."""
        heading = wrap_angle(self.heading + self.loop.trace.poses()[index].heading)
        turn = self.loop.trace.corners[index].turn or 0.0
        previous = self._create(event, corner=_NAMED[event.kind], entry_heading=heading, turn=turn)
        self.loop.node_of[index] = self.current
        if previous >= 0:
            self._join(previous, self.current, event.path_length, _variance(event.path_length))

    def _on_probed(self, outcome: Outcome) -> None:
        """Judges the bend again, now that the wheels are known."""
        if not outcome.succeeded:
            reason = "no corner tells where this boundary begins, and its wall could not be driven twice"
            self._end(False, reason)
            return
        self.phase = Phase.FOLLOW
        self._judge(replace(outcome.result, heading=wrap_angle(self.agent.odometry.heading)))
        if self.listening and not self.agent.is_active("wall-following"):
            self.meter.leave()
            self.agent.start("wall-following", Follow(self.config.side, FollowFrom.WALL))

    def _explore(self) -> None:
        self.agent.stop("wall-following")
        if not self.config.local_maps:
            self._commit()
            return
        self.phase = Phase.EXPLORE
        self.agent.start("local-exploration", self._exploration())

    def _exploration(self) -> ExploreLocally:
        """What to explore, and what is known already: the wall it came along and, if square, the next."""
        assert self._corner is not None
        distance = self.config.wall_distance
        bend = self._corner.kind == BEND
        square = not bend and (self.loop.trace.is_right_angled or len(self.loop.trace.corners) < 3)
        walls = walls_at(self.config.side, self._corner.kind, square=square, distance=distance)
        heading = wrap_angle(self.agent.odometry.heading - self._corner.heading)
        edge = (-distance, -distance * away_from(self.config.side))
        points = (edge,) if self._corner.kind == "convex" else ()
        drift_rate = self.agent.odometry.drift_rate
        return ExploreLocally(self._strategy, heading, walls, square, self._corner.kind, points, drift_rate)

    def _return(self) -> None:
        assert self._corner is not None
        if self._corner.kind == BEND:
            self._commit()
            return
        self.phase = Phase.RETURN
        length = self.loop.trace.corners[-1].length or self._corner.path_length
        if len(self.loop.trace.corners) > 1 and self.loop.trace.corners[-2].kind == "convex":
            # The wall begins only that much after the node before, and its end is seen blurred.
            length -= self.config.wall_distance + 0.015
        self.agent.start("position-correction", ReacquireCorner(self.config.side, self._corner.kind, length))

    def _commit(self) -> None:
        self.phase = Phase.FOLLOW
        super()._commit()

    def _count(self) -> int:
        return len(self.loop.node_of)

    def _go_on(self) -> None:
        """Follows the wall from the corner the robot stands at."""
        assert self._corner is not None
        self.meter.leave()
        start = START_AT[self._corner.kind]
        self.agent.start("wall-following", Follow(self.config.side, start, self._corner.turn))

    def _admit(self, rejected: tuple[CornerObservation, ...]) -> None:
        """They were other places after all: what was taken for known corners becomes nodes, unexplored."""
        for observation in rejected:
            self._add_node(observation.index, observation.event)
            self._hand_over()
        if rejected:
            self.phase = Phase.FOLLOW

    def _close(self) -> None:
        loop = self.loop
        closing = loop.closing
        assert closing is not None
        first, length = loop.node_of[loop.candidate], loop.closing_length
        self._join(self.current, first, length, _variance(length))
        for source, target, length in loop.driven_again():
            self.map.record_traversal(source, target, self.config.side, length)
        self.current = loop.here
        time, met = self.agent.context.time, closing.corners[0].event.number
        self.agent.bus.publish(LoopClosed(time=time, node=first, met=met, past=closing.past))
        self._end(True, "loop closed")


def _variance(distance: float) -> float:
    """Of an arc's length (m^2): encoder noise of 10 % uniform a millimeter, and a corner's 1 mm."""
    return 1e-6 + distance * 1.6e-6
