"""Global navigation: drives arc after arc by wall following, ends known by their corners (section 3.5.1)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.boundary.trace import BEND, BLUNT
from ..agent.events import CornerReached, Event, NodePassed
from ..agent.goals import Follow, FollowFrom, GoAlong, Leg, LegDriven
from ..agent.motion import spin_command
from ..world.robot import STOP, Percept, WheelCommand, wrap_angle
from .wall_following import WallFollowing


@dataclass(frozen=True, slots=True)
class GoToNodeConfig:
    """Settings of global navigation.

    gate (m), gate_slope: a corner of the right kind within max(gate, gate_slope x distance) of the arc's
    length is the arc's end. turn_speed: steps/s. recognize: False ends arcs by path length alone, whatever
    the corner (to measure what recognizing is worth).
    """

    gate: float = 0.05
    gate_slope: float = 0.15
    turn_speed: float = 233.0
    recognize: bool = True


_MISSED = 0.015
"""Meters beyond a blunt corner's place after which it was not met as one this time."""


class Going(Enum):
    """What global navigation is doing."""

    DEPART = "depart"
    TURN = "turn"
    FOLLOW = "follow"
    FACE = "face"


class GoToNode(Behavior):
    """Drives the legs of a path. Goal: `agent.goals.GoAlong`. Result: a tuple of `LegDriven`.

    Succeeds at the last leg's end; gives up where an expected corner does not come.
    """

    name = "go-to-node"
    priority = 20
    States = Going
    initial = Going.DEPART
    Config = GoToNodeConfig
    transitions = (
        Transition("turn", (Going.DEPART, Going.FOLLOW), Going.TURN),
        Transition("follow", (Going.DEPART, Going.TURN, Going.FOLLOW), Going.FOLLOW),
        Transition("face", (Going.DEPART, Going.FOLLOW), Going.FACE),
    )
    Goal = GoAlong
    example = GoAlong((Leg(0, 1, "right", 0.3, "concave", 0.0, FollowFrom.WALL),))
    children: ClassVar = {"follower": WallFollowing}
    config: GoToNodeConfig
    goal: GoAlong
    follower: WallFollowing

    def on_reset(self) -> None:
        """Forgets the path."""
        self._driven: list[LegDriven] = []
        self._remaining = 0.0
        self._path = 0.0
        self._heard: CornerReached | None = None

    def on_start(self, context: Context) -> None:
        """Takes the legs from the goal."""
        self._legs = list(self.goal.legs)

    def on_child_event(self, child: Behavior, event: Event, context: Context) -> None:
        """Hears of corners, and passes everything on."""
        context.publish(event)
        if isinstance(event, CornerReached):
            self._heard = event

    def depart(self, percept: Percept, context: Context) -> Proposal:
        """Stands for a tick before the first leg."""
        if self._legs:
            self._depart()
            return Proposal(STOP, 1.0, "departing")
        self._remaining = self.goal.face
        self.fire("face")
        return Proposal(STOP, 1.0, "arrived")

    def turn(self, percept: Percept, context: Context) -> Proposal:
        """Turns in place to where the leg leads."""
        command = self._turn(context)
        if command is None:
            self.fire("follow")
        return Proposal(command or STOP, 1.0, "turning")

    def face(self, percept: Percept, context: Context) -> Proposal:
        """Turns in place to where it is to face in the end."""
        command = self._turn(context)
        if command is None:
            self.finish(True, "arrived", tuple(self._driven))
        return Proposal(command or STOP, 1.0, "facing")

    def on_enter_follow(self, context: Context) -> None:
        """Begins to follow a wall, unless the leg goes on through the corner at hand."""
        leg = self._legs[0]
        if leg.turn or leg.start is not None:
            self.follower.start(Follow(leg.side, leg.start or FollowFrom.WALL, leg.bend), context)

    def _depart(self) -> None:
        leg = self._legs[0]
        # An arc that ended between corners leaves the follower with a piece of the next one behind it.
        self._path = 0.0 if leg.start is not None else -self.follower.path
        self._remaining = leg.turn
        self.fire("turn" if leg.turn else "follow")

    def _turn(self, context: Context) -> WheelCommand | None:
        """One tick of turning in place, None when it is over."""
        self._remaining -= context.turn
        if abs(self._remaining) > 0.004:
            return spin_command(context.geometry, self._remaining, self.config.turn_speed)
        return None

    def follow(self, percept: Percept, context: Context) -> Proposal | None:
        """Follows the wall to the end of the leg: its corner, or its length where no corner is known."""
        leg = self._legs[0]
        proposal = self.follower.propose(percept, context)
        corner, self._heard = self._heard, None
        if corner is not None:
            self._path += corner.path_length
            if self.config.recognize and corner.kind != BEND:
                return self._meet(corner, leg, context) or proposal
        path = self._path + self.follower.path
        if leg.corner == "none" or not self.config.recognize:
            return proposal if path < leg.distance else self._pass(leg, path, context)
        gate = self._gate(leg.distance)
        stops = len(self._legs) == 1 or self._legs[1].start is not None
        if path > leg.distance + (_MISSED if leg.blunt and stops else gate):
            if leg.blunt:
                return self._pass(leg, path, context)
            self._give_up(
                f"no {leg.corner} corner within {leg.distance + gate:.2f} m after node {leg.source}"
            )
        return proposal

    def _meet(self, corner: CornerReached, leg: Leg, context: Context) -> Proposal | None:
        """A corner: the end of this leg, of one further on if what lies between may be missed, or none."""
        count = self._legs_to(corner)
        for passed in self._legs[: max(0, count - 1)]:
            path, self._path = self._path, passed.distance
            self._arrive(passed, context, recognized=False)
            self._path = path - passed.distance
        if count:
            last = self._legs[0]
            self._arrive(last, context)
            return Proposal(STOP, 1.0, f"at node {last.target}")
        known = leg.corner != "none" and abs(corner.turn) >= BLUNT
        if known and self._path > leg.distance - self._gate(leg.distance):
            self._give_up(
                f"expected a {leg.corner} corner {leg.distance:.2f} m after node {leg.source}, met a "
                f"{corner.kind} one after {self._path:.2f} m"
            )
        return None

    def _legs_to(self, corner: CornerReached) -> int:
        """How many of the legs ahead end with this corner, 0 if none does."""
        way = 0.0
        for count, leg in enumerate(self._legs, 1):
            if count > 1 and leg.start is not None:
                break
            way += leg.distance
            if corner.kind == leg.corner and abs(self._path - way) <= self._gate(way):
                return count
            if not leg.blunt and leg.corner != "none":
                break
        return 0

    def _pass(self, leg: Leg, path: float, context: Context) -> Proposal:
        """Takes the place at hand, `path` m on, for the node, whose corner was not met."""
        self._path = leg.distance
        self._arrive(leg, context, recognized=False)
        if self._legs and self._legs[0].start is None:
            self._path += path - leg.distance
        return Proposal(STOP, 1.0, f"after {leg.distance:.2f} m, at node {leg.target}")

    def _gate(self, distance: float) -> float:
        return max(self.config.gate, self.config.gate_slope * distance)

    def _arrive(self, leg: Leg, context: Context, recognized: bool = True) -> None:
        recognized = recognized and self.config.recognize and leg.corner != "none"
        self._driven.append(LegDriven(leg.source, leg.target, leg.side, self._path, recognized))
        context.publish(NodePassed(time=context.time, node=leg.target))
        self._legs.pop(0)
        if self._legs:
            self._depart()
        else:
            self._remaining = wrap_angle(self.goal.face - self.follower.skew)
            self.fire("face")

    def _give_up(self, reason: str) -> None:
        self.finish(False, reason, tuple(self._driven))
