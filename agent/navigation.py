"""Navigation in a mapped environment, from node to node (section 3.5); `local_navigation` goes on there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..maps.errors import MapError
from ..world.robot import wrap_angle
from .calibration import MismatchLearner
from .events import BehaviorFinished, Lost, NodeReached
from .goals import FollowFrom, GoAlong, Leg, LegDriven

if TYPE_CHECKING:
    from ..maps.hybrid_map import Arc, HybridMap
    from .agent import Agent


_ONWARD = {"concave": FollowFrom.CONCAVE, "convex": FollowFrom.CONVEX, "none": FollowFrom.WALL}
"""What one stands at who goes on by the same wall, by the node's corner."""


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
        legs.append(_leg(hybrid_map, arc, side, first=not legs))
        side = arc.side
    return tuple(legs)


def _leg(hybrid_map: HybridMap, arc: Arc, side: str | None, first: bool) -> Leg:
    begin = hybrid_map.graph.nodes[arc.start]["corner"]
    corner = hybrid_map.graph.nodes[arc.end]["corner"]
    if arc.side == side:
        if not first:
            return Leg(arc.start, arc.end, arc.side, arc.distance, corner)
        start = _ONWARD[begin]
        bend = hybrid_map.graph.nodes[arc.start]["turn"] or None
        return Leg(arc.start, arc.end, arc.side, arc.distance, corner, 0.0, start, bend)
    start = FollowFrom.GAP if begin == "convex" else FollowFrom.WALL
    return Leg(arc.start, arc.end, arc.side, arc.distance, corner, math.pi, start)


class Navigator:
    """Takes the robot from node to node of a map, by the behavior `go-to-node`.

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
        self._subscription = agent.bus.subscribe(BehaviorFinished, self._on_finished)

    def go(self, goal: int) -> None:
        """Sets out for a node; the robot ends in its transition pose. Raises: MapError if there is no way."""
        try:
            arcs = self.map.path(self.node, goal)
        except MapError as error:
            self.legs, self.planned, self.path = [], (), [self.node]
            self._end(False, str(error))
            return
        self.drive(arcs)

    def drive(self, arcs: Iterable[Arc]) -> None:
        """Sets out along arcs, each from where the one before ends; it ends in the transition pose."""
        self.done = self.reached = False
        self.reason = ""
        self.legs = []
        legs = legs_along(self.map, arcs, self.arrival)
        self.planned = legs
        self.path = [self.node, *(leg.target for leg in legs)]
        side = legs[-1].side if legs else self.arrival
        self.agent.start("go-to-node", GoAlong(legs, self._facing(self.path[-1], side)))

    def cancel(self) -> None:
        """Stops where the robot is; `node` is then the last one it was told of, not where it stands."""
        if not self.done:
            self._end(False, "cancelled")
            self.agent.stop("go-to-node")

    def stand_at(self, node: int, arrival: str | None = None) -> None:
        """Tells where the robot is. arrival: as in the constructor."""
        self.node, self.arrival = node, arrival or self.map.meta.side

    def close(self) -> None:
        """Hears and learns no more: for a map that is put away."""
        self._subscription.cancel()
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
        self.legs = list(event.result or ())
        if self.legs:
            self.node = self.legs[-1].target
            self.arrival = self.legs[-1].side
        if event.succeeded:
            self.arrival = self.map.meta.side
            self.agent.bus.publish(NodeReached(time=event.time, node=self.node))
        else:
            self.agent.bus.publish(Lost(time=event.time, reason=event.reason))
        self._end(event.succeeded, event.reason)

    def _end(self, reached: bool, reason: str) -> None:
        self.done, self.reached, self.reason = True, reached, reason
