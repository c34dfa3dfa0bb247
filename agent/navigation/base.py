"""What all navigators share: where the robot is held to be, setting out along arcs, and how a trip ends."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar

from ...maps.errors import MapError
from ..events import Lost, NodePassed, NodeReached
from ..listener import Listener

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap
    from ..agent import Agent
    from ..goals import Leg, LegDriven


class BaseNavigator(Listener):
    """Takes the robot from node to node of a map. How a way is driven is the method's own: `drive`.

    node, arrival: where it holds the robot to be, the side along which it points. Of the last trip, `legs`
    were driven, `planned` were to be driven, `path` are their nodes. It succeeds at its goal.
    """

    behaviors: ClassVar[tuple[str, ...]] = ()
    """What it drives by."""

    def __init__(self, agent: Agent, hybrid_map: HybridMap, node: int, arrival: str | None) -> None:
        """arrival: None means by the side the map was made with: the robot stands in the transition pose."""
        super().__init__(agent)
        self.agent, self.map = agent, hybrid_map
        self.stand_at(node, arrival)
        self.legs: list[LegDriven] = []
        self.planned: tuple[Leg, ...] = ()
        self.path: list[int] = [node]
        self._goal = node

    def stand_at(self, node: int, arrival: str | None = None) -> None:
        """Tells where the robot is. arrival: as in the constructor."""
        self.node, self.arrival = node, arrival or self.map.meta.side

    def go(self, goal: int) -> None:
        """Sets out for a node by the shortest way; the robot ends in its transition pose."""
        self._goal = goal
        self.start()

    def start(self) -> None:
        """Sets out for the node it was told last; it fails at once if there is no way."""
        try:
            self.drive(self.map.path(self.node, self._goal))
        except MapError as error:
            self._set_out(())
            self.finish(False, self.node, str(error))

    def drive(self, arcs: Iterable[Arc]) -> None:
        """Sets out along arcs, each from where the one before ends; it ends in the transition pose."""
        raise NotImplementedError

    def _set_out(self, planned: tuple[Leg, ...]) -> None:
        super().start()
        self.legs, self.planned = [], planned
        self.path = [self.node, *(leg.target for leg in planned)]

    def stop(self, reason: str = "cancelled") -> None:
        """Stops where the robot is; `node` is then the last one it was told of, not where it stands."""
        if not self.done:
            super().stop(reason)
            for name in self.behaviors:
                if name in self.agent.behaviors:
                    self.agent.stop(name)

    @property
    def reached(self) -> bool:
        """Whether the last trip ended at its goal."""
        return self.outcome is not None and self.outcome.succeeded

    @property
    def failed(self) -> Leg | None:
        """The leg on which the last trip ended, if it can be told and did not arrive."""
        return None

    # --- for the methods -----------------------------------------------------------------------------

    def _passed(self, leg: LegDriven) -> None:
        """A leg is driven; the robot stands at its end."""
        self.legs.append(leg)
        self.node, self.arrival = leg.target, leg.side
        self.agent.bus.publish(NodePassed(time=self.agent.context.time, node=leg.target))

    def _arrive(self, reason: str) -> None:
        self.agent.bus.publish(NodeReached(time=self.agent.context.time, node=self.node))
        self.finish(True, self.node, reason)

    def _lose(self, reason: str) -> None:
        self.agent.bus.publish(Lost(time=self.agent.context.time, reason=reason))
        self.finish(False, self.node, reason)
