"""Finds out where on a mapped boundary the robot is, when it was not told.

The robot follows the wall by the side the map was made with. Every corner it meets, every length between two
of them and every turn makes some places of the map more likely than others (`corner_filter`). Where these
cannot decide it looks around at the corner, if the map has views that could (`views`). It settles on a place
only when that one alone explains what was met; in a room that looks the same from several places never.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any

from ...world.robot import wrap_angle
from ..boundary.trace import BEND
from ..events import BehaviorFinished, CornerReached, Localized, Lost, WallMet
from ..goals import START_AT, Follow, Foray, LookAround
from ..listener import Listener, Outcome
from ..walls import away_from
from .corner_filter import BoundaryFilter, LocalizationConfig
from .views import NodeViews

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...world.robot import Percept
    from ..agent import Agent
    from ..behavior import Context

_ROUND = 2.6 * math.pi
"""Turned so far (rad) along one wall: right round an obstacle, and more than any room's corners turn back."""
_AWAY = 0.4 * math.pi
"""Radians to turn from a wall to leave it: not quite across, as the wall beyond a corner may be near."""


class Localizer(Listener):
    """Drives along the boundary until it knows where it is: its result, the node.

    Its reason: "localized", "ambiguous: ..." or what went wrong. length: m of boundary followed. On an
    obstacle that is not on the map, or tells nothing, it crosses open space to another wall.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        config: LocalizationConfig = LocalizationConfig(),  # noqa: B008  frozen
        near: Collection[int] = (),
        on_end: Callable[[Outcome], None] = lambda outcome: None,
    ) -> None:
        """Listens to the agent's events; `start` starts the drive. near: as for `BoundaryFilter`."""
        super().__init__(agent, on_end)
        self.agent = agent
        self.side = hybrid_map.meta.side
        self.filter = BoundaryFilter(hybrid_map, config, near)
        self._before = 0.0
        self._crossings = 0
        self._turned = self._bent = 0.0
        self._leaving = self._looking = False
        self._corner: CornerReached | None = None
        self._views = NodeViews(hybrid_map, agent.robot.geometry.camera_field_of_view)
        self.listen(CornerReached, self._on_corner)
        self.listen(WallMet, self._on_wall)
        self.listen(BehaviorFinished, self._on_finished)

    @property
    def node(self) -> int | None:
        """Where it is; None if it never knew, or does not know yet."""
        return None if self.outcome is None else self.outcome.result

    @property
    def length(self) -> float:
        """Meters of boundary followed, all in all."""
        return self._before + self.filter.length

    def belief(self) -> Mapping[int, float]:
        """Node -> probability that the robot was there at its last corner."""
        ranking = self.filter.ranking
        if self.done or not ranking:
            return {}
        best = ranking[0][0]
        weights = {node: math.exp(score - best) for score, node in ranking}
        total = sum(weights.values())
        return {node: weight / total for node, weight in weights.items()}

    def start(self) -> None:
        """Looks for a wall and follows it."""
        super().start()
        self._follow()

    def _follow(self) -> None:
        self._turned, self._bent, self._corner = 0.0, 0.0, None
        self._leaving = self._looking = False
        self.agent.start("wall-following", Follow(self.side))

    def stop(self, reason: str = "cancelled") -> None:
        """Stops where the robot is, without having found out."""
        if not self.done:
            self._halt()
            super().stop(reason)

    def update(self, percept: Percept, context: Context) -> None:
        """Watches for a boundary that is none of the map's: it turns the other way, or has no corners."""
        if self.done or self._leaving or self._looking:
            return
        self._turned += context.turn
        if abs(self._turned) < _ROUND:
            return
        strange = math.copysign(1.0, self._turned) not in self.filter.senses()
        if strange or self.filter.length == 0.0:
            self._leave("an obstacle that is not on the map")

    def _on_wall(self, event: WallMet) -> None:
        if self._corner is not None and not self.done and not self._leaving:
            self.filter.turned(wrap_angle(event.heading - self._corner.heading))
            self._corner = None

    def _on_corner(self, event: CornerReached) -> None:
        if self.done or self._leaving:
            return
        if event.kind == BEND:
            self._bent += event.path_length
            return
        self._corner = event
        length, self._bent = self._bent + event.path_length, 0.0
        self.filter.corner(event.kind, length)
        if "look-around" in self.agent.behaviors and self._views.any_apart(self.filter.contested):
            self._looking = True
            self.agent.stop("wall-following")
            self.agent.start("look-around", LookAround())
        else:
            self._judge()

    def _judge(self) -> None:
        """Ends if it knows where it is, or will not; else it drives on."""
        node = self.filter.estimate
        if node is not None:
            self.agent.bus.publish(Localized(time=self.agent.context.time, node=node))
            self._halt()
            self.finish(True, node, "localized")
        elif self.filter.length > self.filter.config.loops * self.filter.boundary_length:
            nodes = ", ".join(map(str, self.filter.hypotheses))
            reason = f"ambiguous: cannot tell nodes {nodes} apart"
            if self.filter.boundaries > 1:
                self._leave(reason)
            else:
                self._lose(reason)

    def _leave(self, reason: str) -> None:
        """Straight away from the wall it follows, to another one; a few times, then it gives up."""
        if self._crossings >= self.filter.config.forays:
            self._lose(reason)
            return
        self._crossings += 1
        self._leaving = True
        self._before += self.filter.length
        self.filter.restart()
        self.agent.stop("wall-following")
        away = _AWAY * away_from(self.side)
        self.agent.start("foray", Foray(away, self.filter.loop_length))

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior == "foray" and self._leaving and not self.done:
            self._follow()
        elif event.behavior == "look-around" and self._looking and not self.done:
            self._looked(event.result)

    def _looked(self, panorama: Any) -> None:
        """Takes what it saw at the corner, and goes on from there if that is not enough."""
        self._looking = False
        if panorama is not None:
            self.filter.seen(self._views.against(panorama, self.filter.likely))
        self._judge()
        if not self.done and not self._leaving and self._corner is not None:
            self.agent.start("wall-following", Follow(self.side, START_AT[self._corner.kind]))

    def _lose(self, reason: str) -> None:
        self._halt()
        self.agent.bus.publish(Lost(time=self.agent.context.time, reason=reason))
        self.finish(False, reason=reason)

    def _halt(self) -> None:
        self.agent.stop("look-around" if self._looking else "wall-following")
        self.close()
