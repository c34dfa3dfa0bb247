"""Navigation by corners: legs end at recognized corners; `local` goes on around a node (section 3.5)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...world.robot import wrap_angle
from ..estimation.wheel_calibration import MismatchLearner
from ..events import BehaviorFinished
from ..goals import FollowFrom, GoAlong, Leg, LegDriven
from ..listener import Outcome
from .base import BaseNavigator
from .crossing import CrossingDrive, CrossingGates
from .legs import legs_along

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap
    from ..agent import Agent


class Navigator(BaseNavigator):
    """Takes the robot from node to node of a map, by the behavior `go-to-node` and by crossings."""

    behaviors = ("go-to-node",)

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        node: int,
        arrival: str | None = None,
        *,
        learn_mismatch: bool = True,
    ) -> None:
        """arrival: as in the base. learn_mismatch: whether to go on learning it along walls."""
        super().__init__(agent, hybrid_map, node, arrival)
        track = agent.robot.geometry.track
        self.mismatch = MismatchLearner(agent, agent.odometry, track) if learn_mismatch else None
        self.gates = CrossingGates()
        self._waiting: list[Leg] = []
        self._crossing: Leg | None = None
        self._skew = 0.0
        self._drive = CrossingDrive(agent, hybrid_map.meta.side, self._on_crossed)
        self.listen(BehaviorFinished, self._on_finished)

    def drive(self, arcs: Iterable[Arc]) -> None:
        """Sets out along arcs. Raises: MapError if the map does not say how one of them is driven."""
        legs = legs_along(self.map, arcs, self.arrival)
        self._set_out(legs)
        self._waiting, self._skew = list(legs), 0.0
        self._proceed()

    def _proceed(self) -> None:
        """The next crossing, or all legs along walls up to it; they end in the transition pose."""
        leg = self._waiting[0] if self._waiting else None
        if leg is not None and leg.crossing is not None and self.arrival == self.map.meta.side:
            self._crossing = self._waiting.pop(0)
            self._drive.begin(leg.crossing, leg.start or FollowFrom.CONCAVE, leg.bend)
            return
        legs: list[Leg] = []
        while self._waiting and self._waiting[0].crossing is None:
            legs.append(self._waiting.pop(0))
        side = legs[-1].side if legs else self.arrival
        last = legs[-1].target if legs else self.node
        face = wrap_angle(self._facing(last, side) - (0.0 if legs else self._skew))
        self.agent.start("go-to-node", GoAlong(tuple(legs), face))

    def stop(self, reason: str = "cancelled") -> None:
        """Stops where the robot is."""
        if not self.done:
            super().stop(reason)
            self._waiting, self._crossing = [], None
            self._drive.stop()

    def close(self) -> None:
        """Hears and learns no more: for a map that is put away."""
        super().close()
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
            self._lose(event.reason)
            return
        self.arrival, self._skew = self.map.meta.side, 0.0
        if self._waiting:
            self._proceed()
        else:
            self._arrive(event.reason)

    def _on_crossed(self, outcome: Outcome) -> None:
        """A crossing ended: at the node it leads to, if it went as the map says."""
        leg, self._crossing = self._crossing, None
        if leg is None or leg.crossing is None or self.done:
            return
        reason = outcome.reason
        if outcome.succeeded:
            driven, corner = outcome.result
            reason = self.gates.misfit(leg.crossing, driven)
            if corner.kind != leg.corner and not reason:
                reason = f"a {corner.kind} corner, not a {leg.corner} one"
        if reason:
            self._lose(f"the foray from node {leg.source} to {leg.target} failed: {reason}")
            return
        self._skew = wrap_angle(self.agent.odometry.heading - corner.heading)
        length = driven.offset + driven.distance + driven.join
        self._passed(LegDriven(leg.source, leg.target, leg.side, length, True, True))
        self._proceed()
