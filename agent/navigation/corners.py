"""Navigation in a mapped environment, from node to node (section 3.5); `local_navigation` goes on there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...maps.errors import MapError
from ...world.robot import wrap_angle
from ..boundary.trace import BLUNT
from ..estimation.wheel_calibration import MismatchLearner
from ..events import BehaviorFinished, CornerReached, Lost, NodePassed, NodeReached
from ..goals import Crossing, FollowFrom, GoAlong, Leg, LegDriven
from .crossing import ForayDrive, ForayGates

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap
    from ..agent import Agent


ONWARD = {"concave": FollowFrom.CONCAVE, "convex": FollowFrom.CONVEX, "none": FollowFrom.WALL}
"""What one stands at who goes on by the same wall, by the node's corner."""
CROSSING = "crossing"
"""Note of a foray's arc: how it is driven, the fields of `goals.Crossing`."""


def plan_legs(hybrid_map: HybridMap, start: int, arrival: str, goal: int) -> tuple[Leg, ...]:
    """The shortest way (A* over the graph) as legs to drive. Raises: MapError if there is none.

    arrival: the side of the wall by which the robot came to `start`, which says how it stands there: in the
    entry heading if that is the side the map was made by, else as it arrives from the other direction.
    """
    return legs_along(hybrid_map, hybrid_map.path(start, goal), arrival)


def legs_along(hybrid_map: HybridMap, arcs: Iterable[Arc], arrival: str) -> tuple[Leg, ...]:
    """These arcs as legs to drive, one after the other. arrival: as for `plan_legs`."""
    legs: list[Leg] = []
    side: str | None = arrival
    for arc in arcs:
        if arc.kind == "foray":
            legs.append(_foray_leg(hybrid_map, arc))
        else:
            legs.append(_leg(hybrid_map, arc, side, first=not legs or legs[-1].crossing is not None))
        side = arc.side
    return tuple(legs)


def _foray_leg(hybrid_map: HybridMap, arc: Arc) -> Leg:
    """Raises: MapError if the map does not say how the foray is driven."""
    try:
        crossing = Crossing(**arc.notes[CROSSING])
    except (KeyError, TypeError):
        raise MapError(
            f"arc {arc.start} -> {arc.end} (foray): its notes lack {CROSSING!r}, how it is driven"
        ) from None
    data = hybrid_map.graph.nodes[arc.start]
    start = ONWARD[data["corner"]]
    corner = hybrid_map.graph.nodes[arc.end]["corner"]
    return Leg(arc.start, arc.end, arc.side, arc.distance, corner, 0.0, start, data["turn"] or None, crossing)


def _leg(hybrid_map: HybridMap, arc: Arc, side: str | None, first: bool) -> Leg:
    nodes = hybrid_map.graph.nodes
    begin, corner = nodes[arc.start]["corner"], nodes[arc.end]["corner"]
    turn, start, bend = 0.0, None, None
    if arc.side != side:
        turn, start = math.pi, FollowFrom.GAP if begin == "convex" else FollowFrom.WALL
    elif first:
        start, bend = ONWARD[begin], nodes[arc.start]["turn"] or None
    blunt = corner != "none" and 0.0 < abs(nodes[arc.end]["turn"]) < BLUNT
    return Leg(arc.start, arc.end, arc.side, arc.distance, corner, turn, start, bend, blunt=blunt)


class Navigator:
    """Takes the robot from node to node of a map, by the behavior `go-to-node` and by forays.

    node, arrival: where it holds the robot to be, and the side it came by. After `go`, `done` says that the
    trip has ended and `reached` how; `legs` are the arcs driven, `reason` why it ended.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        node: int,
        arrival: str | None = None,
        *,
        learn_mismatch: bool = True,
    ) -> None:
        """arrival: None means by the side the map was made with: the robot stands in the transition pose.

        learn_mismatch: whether to go on learning the wheels' mismatch along the walls that are followed.
        """
        self.agent = agent
        self.map = hybrid_map
        self.node = node
        self.arrival = arrival or hybrid_map.meta.side
        self.legs: list[LegDriven] = []
        self.planned: tuple[Leg, ...] = ()
        self.path: list[int] = [node]
        self.done = False
        self.reached = False
        self.reason = ""
        self.mismatch = MismatchLearner(agent) if learn_mismatch else None
        self.gates = ForayGates()
        self._waiting: list[Leg] = []
        self._foray: Leg | None = None
        self._skew = 0.0
        self._drive = ForayDrive(agent, hybrid_map.meta.side, self._on_foray)
        self._subscription = agent.bus.subscribe(BehaviorFinished, self._on_finished)

    def go(self, goal: int) -> None:
        """Sets out for a node; the robot ends in its transition pose. Raises: MapError if there is no way."""
        try:
            self.drive(self.map.path(self.node, goal))
        except MapError as error:
            self.legs, self.planned, self.path = [], (), [self.node]
            self._end(False, str(error))

    def drive(self, arcs: Iterable[Arc]) -> None:
        """Sets out along arcs, each from where the one before ends; it ends in the transition pose.

        Raises: MapError if the map does not say how one of them is driven.
        """
        legs = legs_along(self.map, arcs, self.arrival)
        self.done = self.reached = False
        self.reason = ""
        self.legs = []
        self.planned = legs
        self.path = [self.node, *(leg.target for leg in legs)]
        self._waiting, self._skew = list(legs), 0.0
        self._proceed()

    def _proceed(self) -> None:
        """The next foray, or all legs along walls up to it; they end in the transition pose."""
        leg = self._waiting[0] if self._waiting else None
        if leg is not None and leg.crossing is not None and self.arrival == self.map.meta.side:
            self._foray = self._waiting.pop(0)
            self._drive.begin(leg.crossing, leg.start or FollowFrom.CONCAVE, leg.bend)
            return
        legs: list[Leg] = []
        while self._waiting and self._waiting[0].crossing is None:
            legs.append(self._waiting.pop(0))
        side = legs[-1].side if legs else self.arrival
        last = legs[-1].target if legs else self.node
        face = wrap_angle(self._facing(last, side) - (0.0 if legs else self._skew))
        self.agent.start("go-to-node", GoAlong(tuple(legs), face))

    def cancel(self) -> None:
        """Stops where the robot is; `node` is then the last one it was told of, not where it stands."""
        if not self.done:
            self._end(False, "cancelled")
            self._waiting, self._foray = [], None
            self._drive.stop()
            self.agent.stop("go-to-node")

    def stand_at(self, node: int, arrival: str | None = None) -> None:
        """Tells where the robot is. arrival: as in the constructor."""
        self.node, self.arrival = node, arrival or self.map.meta.side

    def close(self) -> None:
        """Hears and learns no more: for a map that is put away."""
        self._subscription.cancel()
        self._drive.close()
        if self.mismatch is not None:
            self.mismatch.close()

    @property
    def failed(self) -> Leg | None:
        """The leg on which the last trip ended, if it did not arrive."""
        if not self.done or self.reached or len(self.legs) >= len(self.planned):
            return None
        return self.planned[len(self.legs)]

    def _facing(self, node: int, side: str) -> float:
        """How far to turn (rad) from how one arrives by `side` to the node's entry heading."""
        if side == self.map.meta.side:
            return 0.0
        return wrap_angle(math.pi - self.map.graph.nodes[node]["turn"])

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior != "go-to-node" or self.done:
            return
        driven = list(event.result or ())
        self.legs += driven
        if driven:
            self.node, self.arrival = driven[-1].target, driven[-1].side
        if not event.succeeded:
            self._fail(event.time, event.reason)
            return
        self.arrival, self._skew = self.map.meta.side, 0.0
        if self._waiting:
            self._proceed()
        else:
            self._arrive(event.time, event.reason)

    def _on_foray(self, driven: Crossing | None, corner: CornerReached | None, reason: str) -> None:
        """A foray ended: at the node it leads to, if it went as the map says."""
        leg, self._foray = self._foray, None
        if leg is None or leg.crossing is None or self.done:
            return
        time = self.agent.context.time
        if driven is not None and corner is not None:
            reason = self.gates.misfit(leg.crossing, driven)
            if corner.kind != leg.corner and not reason:
                reason = f"a {corner.kind} corner, not a {leg.corner} one"
        if driven is None or corner is None or reason:
            self._fail(time, f"the foray from node {leg.source} to {leg.target} failed: {reason}")
            return
        length = driven.offset + driven.distance + driven.join
        self.legs.append(LegDriven(leg.source, leg.target, leg.side, length, True, True))
        self.node, self.arrival = leg.target, leg.side
        self._skew = wrap_angle(self.agent.odometry.heading - corner.heading)
        self.agent.bus.publish(NodePassed(time=time, node=leg.target))
        self._proceed()

    def _arrive(self, time: float, reason: str) -> None:
        self.agent.bus.publish(NodeReached(time=time, node=self.node))
        self._end(True, reason)

    def _fail(self, time: float, reason: str) -> None:
        self.agent.bus.publish(Lost(time=time, reason=reason))
        self._end(False, reason)

    def _end(self, reached: bool, reason: str) -> None:
        self.done, self.reached, self.reason = True, reached, reason
