"""Goes to nodes of a map whatever happened before: finds out where it is first, and other ways after.

A navigator takes for granted that the robot stands at its node. Here is kept whether it does: not after a
trip was cancelled or failed between two nodes, nor after something else drove the robot away.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from ...world.robot import Pose, wrap_angle
from ..events import Event, NodePassed, Stuck
from ..goals import Leg, LegDriven
from ..localization.corner_filter import CHANGED, LocalizationConfig
from ..localization.localizer import Localizer

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent

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

_BACK = {"right": "left", "left": "right"}


class AnyNavigator(Protocol):
    """What a trip needs of a navigator, whichever the profile names."""

    agent: Agent
    map: HybridMap
    node: int
    legs: list[LegDriven]
    planned: tuple[Leg, ...]
    path: list[int]
    done: bool
    reached: bool
    reason: str

    @property
    def arrival(self) -> str:
        """The side along which the robot came to `node`, or that of the map in the transition pose."""

    @property
    def failed(self) -> Leg | None:
        """The leg on which the last trip ended, if it can be told and did not arrive."""

    def go(self, goal: int) -> None:
        """Sets out for a node."""

    def cancel(self) -> None:
        """Stops where the robot is, between two nodes or not."""

    def stand_at(self, node: int, arrival: str | None = None) -> None:
        """Tells where the robot is, and the side it came by (None: it stands in the transition pose)."""

    def close(self) -> None:
        """Hears no more events; called when the map is put away."""


class RecoveringNavigator:
    """Takes the robot to nodes of one map, one trip after the other. Call `update` once a tick during a trip.

    done, reached, reason: how the last trip stands. Of it, all attempts together: `legs`, the arcs driven;
    `path`, the nodes; `reasons`, why each ended; `blocked`, arcs that could not be driven, marked as blocked
    in the map. localizer: what found out last where the robot is, if anything had to.
    """

    def __init__(
        self, agent: Agent, hybrid_map: HybridMap, navigator: AnyNavigator, localizes: bool = True
    ) -> None:
        """The robot stands at the navigator's node now. localizes: whether it may find out where it is."""
        self.agent, self.map, self.navigator = agent, hybrid_map, navigator
        self._localizes = localizes
        self.localizer: Localizer | None = None
        self._localizing = False
        self._stood: Pose | None = agent.odometry.pose
        self._left = agent.odometry.pose
        self._near: tuple[int, ...] = ()
        self._passed = 0
        self._set_out_at = 0.0
        self._stuck = False
        self._goal = navigator.node
        self._attempts = 0
        self._limit = 0.0
        self.done, self.reached, self.reason = True, False, ""
        self._begin_records()
        self._subscriptions = [
            agent.bus.subscribe(NodePassed, self._on_passed),
            agent.bus.subscribe(Stuck, self._on_stuck),
        ]

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

    def go(self, goal: int) -> None:
        """Sets out. Where the robot is not known to be at a node it finds out first."""
        self.done = self.reached = self._stuck = False
        self.reason = ""
        self._begin_records()
        self._goal, self._attempts = goal, ATTEMPTS
        if self.node is None:
            self._localize(self.near)
        else:
            self._set_out()

    def update(self) -> None:
        """Goes on with the trip. Called once a tick."""
        if self.done:
            return
        late = self.agent.context.time > self._limit
        if self._stuck or late:
            reason = "stuck" if self._stuck else f"not at node {self._goal} in time"
            self.cancel()
            self.reason = reason
            self.reasons.append(reason)
        elif self._localizing:
            if self.localizer is not None and self.localizer.done:
                self._found(self.localizer)
        elif self.navigator.done:
            self._ended()

    def cancel(self) -> None:
        """Stops where the robot is; the next trip begins there, wherever that is."""
        if self.done:
            return
        if self._localizing and self.localizer is not None:
            self.localizer.cancel()
            self.lose(self.near)
        else:
            self.navigator.cancel()
            self._collect()
            if not self._is_there():
                self.lose(self._around())
        self._end(False, "cancelled")

    def close(self) -> None:
        """Hears no more events."""
        self.cancel()
        self.navigator.close()
        for subscription in self._subscriptions:
            subscription.cancel()

    # --- inside ----------------------------------------------------------------------------------------

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
        self.localizer = localizer = Localizer(self.agent, self.map, config, near)
        self._localizing = True
        self._limit = self.agent.context.time + PATIENCE + 3.0 * TIME_PER_METER * localizer.filter.loop_length
        localizer.begin()

    def _found(self, localizer: Localizer) -> None:
        self._localizing = False
        if localizer.node is None:
            self.lose()
            self.reasons.append(localizer.reason)
            self._end(False, f"the robot does not know where it is: {localizer.reason}")
        else:
            self.stand_at(localizer.node)
            self._set_out()

    def _set_out(self) -> None:
        self._attempts -= 1
        self._passed = 0
        self._set_out_at = self.agent.odometry.travelled
        self.navigator.go(self._goal)
        length = sum(leg.distance for leg in self.navigator.planned)
        self._limit = self.agent.context.time + PATIENCE + TIME_PER_METER * length

    def _ended(self) -> None:
        """One way was driven to its end, or as far as it led."""
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
        onward, before = self.map.next_arc(here, side), self.map.next_arc(here, _BACK[side])
        return (here, *(arc.end for arc in (onward, before) if arc is not None))

    def _block(self, leg: Leg) -> None:
        """Marks an arc and its reverse as blocked, in memory; a foray has none."""
        ways = [(leg.source, leg.target, leg.kind)]
        if leg.crossing is None:
            ways.append((leg.target, leg.source, _BACK[leg.side]))
        for start, end, kind in ways:
            if self.map.graph.has_edge(start, end, kind):
                self.map.block(start, end, kind)
                self.blocked.append((start, end, kind))

    def _on_passed(self, event: Event) -> None:
        self._passed += 1
        self._set_out_at = self.agent.odometry.travelled

    def _on_stuck(self, event: Stuck) -> None:
        self._stuck |= event.given_up

    def _end(self, reached: bool, reason: str) -> None:
        self._localizing = False
        self.done, self.reached, self.reason = True, reached, reason
