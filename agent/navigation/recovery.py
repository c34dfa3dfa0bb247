"""Goes to nodes of a map whatever happened before: finds out where it is first, and other ways after.

A navigator takes for granted that the robot stands at its node. Here is kept whether it does: not after a
trip was cancelled or failed between two nodes, nor after something else drove the robot away.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from ...maps.sides import other_side
from ...world.robot import Percept, Pose, wrap_angle
from ..events import NodePassed, Stuck
from ..listener import Listener, Outcome
from ..localization.corner_filter import CHANGED, LocalizationConfig
from ..localization.localizer import Localizer

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent
    from ..behavior import Context
    from ..goals import Leg, LegDriven
    from .base import BaseNavigator

ATTEMPTS = 4
"""Ways tried to a node before a trip is given up."""
PATIENCE = 120.0
"""Simulated seconds that a trip may take, besides `TIME_PER_METER`."""
TIME_PER_METER = 120.0
"""Simulated seconds that a trip may take for each meter of its arcs."""
_MOVED, _TURNED = 0.005, 0.05
"""Meters and rad by odometry up to which the robot still stands where it stood."""
_AWAY = 0.05
"""Meters by odometry beyond which nothing is known of where it was stopped."""


class Doing(Enum):
    """What a trip is about."""

    RESTING = "no trip"
    LOCALIZING = "finding out where it is"
    DRIVING = "driving"


class RecoveringNavigator(Listener):
    """Takes the robot to nodes of one map, one trip after the other, by a navigator and a localizer.

    Of the last trip, all attempts together: `legs`, the arcs driven; `path`, the nodes; `reasons`, why each
    ended; `blocked`, arcs that could not be driven, marked as blocked in the map. localizer: what found out
    last where the robot is, if anything had to.
    """

    def __init__(
        self, agent: Agent, hybrid_map: HybridMap, navigator: BaseNavigator, localizes: bool = True
    ) -> None:
        """The robot stands at the navigator's node now. localizes: whether it may find out where it is."""
        super().__init__(agent)
        self.agent, self.map, self.navigator = agent, hybrid_map, navigator
        navigator.on_end = self._on_driven
        self._localizes = localizes
        self.localizer: Localizer | None = None
        self._doing = Doing.RESTING
        self._stood: Pose | None = agent.odometry.pose
        self._left = agent.odometry.pose
        self._near: tuple[int, ...] = ()
        self._passed = 0
        self._set_out_at = 0.0
        self._goal = navigator.node
        self._attempts = 0
        self._limit = 0.0
        self._begin_records()
        self.listen(NodePassed, self._on_passed)
        self.listen(Stuck, self._on_stuck)

    def _begin_records(self) -> None:
        self.legs: list[LegDriven] = []
        self.path: list[int] = []
        self.reasons: list[str] = []
        self.blocked: list[tuple[int, int, str]] = []

    @property
    def attempts(self) -> int:
        """Ways tried on the last trip."""
        return ATTEMPTS - self._attempts

    @property
    def node(self) -> int | None:
        """Where the robot stands, None if it does not know."""
        return self.navigator.node if self._is_there() else None

    @property
    def near(self) -> tuple[int, ...]:
        """The nodes of which it meets one first, if it knows no more than that."""
        away = self.agent.odometry.pose.distance_to(self._left) > _AWAY
        return () if away or self.node is not None else self._near

    def stand_at(self, node: int, arrival: str | None = None) -> None:
        """Tells it where the robot stands."""
        self.navigator.stand_at(node, arrival)
        self._stood = self.agent.odometry.pose

    def lose(self, near: tuple[int, ...] = ()) -> None:
        """Tells it that the robot's place is not known; near: nodes of which it meets one first."""
        self._stood, self._near, self._left = None, near, self.agent.odometry.pose

    @property
    def under_way(self) -> bool:
        """Whether a trip has begun and not ended."""
        return self._doing is not Doing.RESTING

    @property
    def reached(self) -> bool:
        """Whether the last trip ended at its goal."""
        return self.outcome is not None and self.outcome.succeeded

    def go(self, goal: int) -> None:
        """Sets out for a node."""
        self._goal = goal
        self.start()

    def start(self) -> None:
        """Sets out for the node it was told last; if it is not known to be at one, it finds out first."""
        super().start()
        self._begin_records()
        self._attempts = ATTEMPTS
        if self.node is None:
            self._localize(self.near)
        else:
            self._set_out()

    def update(self, percept: Percept, context: Context) -> None:
        """Watches the time that the trip takes."""
        if context.time > self._limit:
            self._give_up(f"not at node {self._goal} in time")
        elif self._doing is Doing.DRIVING and self.navigator.outcome is not None:
            self._on_driven(self.navigator.outcome)  # there was no way to begin with

    def stop(self, reason: str = "cancelled") -> None:
        """Stops where the robot is; the next trip begins there, wherever that is."""
        if self.under_way:
            self._break_off()
            super().stop(reason)

    def close(self) -> None:
        """Stops and hears no more."""
        self.stop()
        self.navigator.close()
        super().close()

    # --- inside ----------------------------------------------------------------------------------------

    def _give_up(self, reason: str) -> None:
        self._break_off()
        self.reasons.append(reason)
        self.finish(False, reason=reason)

    def _break_off(self) -> None:
        """Stops what is under way and takes note of where that leaves the robot."""
        doing, self._doing = self._doing, Doing.RESTING
        if doing is Doing.LOCALIZING and self.localizer is not None:
            self.localizer.stop()
            self.lose(self.near)
            return
        self.navigator.stop()
        self._collect()
        if not self._is_there():
            self.lose(self._around())

    def _is_there(self) -> bool:
        stood, pose = self._stood, self.agent.odometry.pose
        if stood is None:
            return False
        turned = abs(wrap_angle(pose.heading - stood.heading))
        return pose.distance_to(stood) <= _MOVED and turned <= _TURNED

    def _localize(self, near: tuple[int, ...], changed: bool = False) -> None:
        if not self._localizes:
            self._end(False, "the robot does not know where it is, and its profile has no way to find out")
            return
        config = CHANGED if changed else LocalizationConfig()
        self.localizer = localizer = Localizer(self.agent, self.map, config, near, self._on_localized)
        self._doing = Doing.LOCALIZING
        self._limit = self.agent.context.time + PATIENCE + 3.0 * TIME_PER_METER * localizer.filter.loop_length
        localizer.start()

    def _on_localized(self, outcome: Outcome) -> None:
        if outcome.succeeded:
            self.stand_at(outcome.result)
            self._set_out()
        else:
            self.lose()
            self.reasons.append(outcome.reason)
            self._end(False, f"the robot does not know where it is: {outcome.reason}")

    def _set_out(self) -> None:
        self._attempts -= 1
        self._passed = 0
        self._set_out_at = self.agent.odometry.travelled
        self._doing = Doing.RESTING
        self.navigator.go(self._goal)
        length = sum(leg.distance for leg in self.navigator.planned)
        self._limit = self.agent.context.time + PATIENCE + TIME_PER_METER * length
        self._doing = Doing.DRIVING

    def _on_driven(self, outcome: Outcome) -> None:
        """One way was driven to its end, or as far as it led."""
        if self._doing is not Doing.DRIVING:
            return
        self._collect()
        navigator = self.navigator
        self.reasons.append(navigator.reason)
        if navigator.reached:
            self._stood = self.agent.odometry.pose
            self._end(True, navigator.reason)
            return
        failed = navigator.failed
        if not self._is_there():
            # Not where it thought it was, it may be anywhere.
            self.lose()
        if failed is not None and self._localizes:
            self._block(failed)
            if self._attempts:
                self._localize((), changed=True)
                return
        self._end(False, navigator.reason)

    def _collect(self) -> None:
        driven = self.navigator.legs
        self.legs += driven
        self.path += self.navigator.path[: len(driven) + 1]

    def _around(self) -> tuple[int, ...]:
        """The nodes of which one is met first from here, following the wall by the map's side.

        On its way along an arc by that side it can be but the arc's end; by the other side the robot has yet
        to turn around, at one of the two. At a node, what it will meet depends on where it points.
        """
        planned = self.navigator.planned
        side = self.map.meta.side
        here = planned[self._passed - 1].target if self._passed else self.navigator.node
        driven = self.agent.odometry.travelled - self._set_out_at
        if self._passed < len(planned) and driven > _AWAY:
            leg = planned[self._passed]
            if leg.crossing is not None:
                return ()
            if driven < leg.distance - 2.0 * _AWAY:
                return (leg.target,) if leg.side == side else (leg.source, leg.target)
            here = leg.target
        onward, before = self.map.next_arc(here, side), self.map.next_arc(here, other_side(side))
        return (here, *(arc.end for arc in (onward, before) if arc is not None))

    def _block(self, leg: Leg) -> None:
        """Marks an arc and its reverse as blocked, in memory; a crossing has none."""
        ways = [(leg.source, leg.target, leg.kind)]
        if leg.crossing is None:
            ways.append((leg.target, leg.source, other_side(leg.side)))
        for start, end, kind in ways:
            if self.map.graph.has_edge(start, end, kind):
                self.map.block(start, end, kind)
                self.blocked.append((start, end, kind))

    def _on_passed(self, event: NodePassed) -> None:
        self._passed += 1
        self._set_out_at = self.agent.odometry.travelled

    def _on_stuck(self, event: Stuck) -> None:
        if event.given_up and self.under_way:
            self._give_up("stuck")

    def _end(self, reached: bool, reason: str) -> None:
        self._doing = Doing.RESTING
        self.finish(reached, self._goal if reached else None, reason)
