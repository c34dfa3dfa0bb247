"""Foray: straight across open space until a wall is near; how free-standing obstacles are found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import Foray
from ..agent.motion import drive_command, spin_command
from ..world.robot import (
    LEFT,
    LEFT_DIAGONAL,
    LEFT_FRONT,
    RIGHT,
    RIGHT_DIAGONAL,
    RIGHT_FRONT,
    STOP,
    Percept,
    wrap_angle,
)


@dataclass(frozen=True, slots=True)
class ForayConfig:
    """Settings. speed, turn_speed: steps/s. clearance: m from the rim, ahead, at which a wall is reached.

    side_clearance: the same for the two sensors at the sides, against walls that are met at a slant.
    heading_gain: 1/s, how fast a deviation from the heading is steered out. leave: m driven before
    walls count, as a foray begins beside one.
    """

    speed: float = 233.0
    turn_speed: float = 233.0
    clearance: float = 0.022
    side_clearance: float = 0.008
    heading_gain: float = 4.0
    leave: float = 0.05


class Foraying(Enum):
    """TURNING: to the heading of the crossing. CROSSING: driving straight. ARRIVED: a wall is near."""

    TURNING = "turning"
    CROSSING = "crossing"
    ARRIVED = "arrived"


class ForayBehavior(Behavior):
    """Drives straight until a wall is near. Goal: `agent.goals.Foray`. Result: the distance driven (m).

    The heading is kept by path integration. It fails if no wall comes within the goal's distance.
    """

    name = "foray"
    priority = 40
    States = Foraying
    initial = Foraying.TURNING
    Config = ForayConfig
    transitions = (
        Transition("cross", Foraying.TURNING, Foraying.CROSSING),
        Transition("arrive", Foraying.CROSSING, Foraying.ARRIVED),
    )
    Goal = Foray
    config: ForayConfig
    goal: Foray

    def on_reset(self) -> None:
        """Forgets the heading and how far it has come."""
        self._heading: float | None = None
        self._driven = 0.0

    def turning(self, percept: Percept, context: Context) -> Proposal:
        """Turns in place to the heading of the crossing."""
        deviation = self._deviation(context)
        if abs(deviation) > 0.01:
            command = spin_command(context.geometry, deviation, self.config.turn_speed)
            return Proposal(command, reason="turning to the heading of the foray")
        self.fire("cross")
        return self._cross(percept, context)

    def crossing(self, percept: Percept, context: Context) -> Proposal:
        """Drives straight until a wall is near or the goal's distance is over."""
        self._driven += context.distance
        return self._cross(percept, context)

    def arrived(self, percept: Percept, context: Context) -> Proposal:
        """Stands at the wall."""
        return Proposal(STOP, reason="arrived at a wall")

    def _deviation(self, context: Context) -> float:
        if self._heading is None:
            self._heading = wrap_angle(context.pose.heading + self.goal.turn)
        return wrap_angle(self._heading - context.pose.heading)

    def _cross(self, percept: Percept, context: Context) -> Proposal:
        if self._wall_near(percept, context):
            self.fire("arrive")
            self.finish(True, "a wall is near", result=self._driven)
            return Proposal(STOP, reason="arrived at a wall")
        most = self.goal.max_distance
        if self._driven >= most:
            self.finish(False, f"no wall within {most:g} m", result=self._driven)
            return Proposal(STOP, reason="nothing found")
        turn_rate = self.config.heading_gain * self._deviation(context)
        command = drive_command(context.geometry, self.config.speed, turn_rate)
        return Proposal(command, reason="crossing open space")

    def _wall_near(self, percept: Percept, context: Context) -> bool:
        infrared, distance = percept.infrared, context.geometry.infrared_distance
        ahead = min(distance(infrared[RIGHT_FRONT]), distance(infrared[LEFT_FRONT]))
        if ahead < self.config.clearance:
            return True
        if self._driven < self.config.leave:
            return False
        slanted = min(distance(infrared[RIGHT_DIAGONAL]), distance(infrared[LEFT_DIAGONAL]))
        beside = min(distance(infrared[RIGHT]), distance(infrared[LEFT]))
        return bool(slanted < self.config.clearance or beside < self.config.side_clearance)
