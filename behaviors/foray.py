"""Foray: straight across open space until a wall is near; how free-standing obstacles are found."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.maneuvers import Foray
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
    """Drives straight until a wall is near. Goal: `agent.maneuvers.Foray`. Result: the distance driven (m).

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
    example_goal = Foray(turn=0.5)
    config: ForayConfig

    def on_reset(self) -> None:
        """Forgets the goal."""
        self._goal: Foray | None = None
        self._heading: float | None = None
        self._driven = 0.0

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes the goal. Raises: TypeError for another kind of goal, ValueError if it leads nowhere."""
        if not isinstance(goal, Foray):
            raise TypeError(f"{self.name} needs a Foray goal, not {goal!r}")
        if not (math.isfinite(goal.turn) and goal.max_distance > 0.0):
            raise ValueError(f"{self.name}: turn must be finite and max_distance > 0, not {goal!r}")
        self._goal = goal

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """Turns, then drives, then stands."""
        goal = self._goal
        if goal is None:
            raise TypeError(f"{self.name} was asked before it was given a Foray goal")
        if self._heading is None:
            self._heading = wrap_angle(context.pose.heading + goal.turn)
        deviation = wrap_angle(self._heading - context.pose.heading)
        if self.state is Foraying.TURNING:
            if abs(deviation) > 0.01:
                command = spin_command(context.geometry, deviation, self.config.turn_speed)
                return Proposal(command, reason="turning to the heading of the foray")
            self.fire("cross")
        elif self.state is Foraying.CROSSING:
            self._driven += context.distance
        return self._cross(goal, deviation, percept, context)

    def _cross(self, goal: Foray, deviation: float, percept: Percept, context: Context) -> Proposal:
        if self._wall_near(percept, context):
            self.fire("arrive")
            self.finish(True, "a wall is near", result=self._driven)
            return Proposal(STOP, reason="arrived at a wall")
        if self._driven >= goal.max_distance:
            self.finish(False, f"no wall within {goal.max_distance:g} m", result=self._driven)
            return Proposal(STOP, reason="nothing found")
        command = drive_command(context.geometry, self.config.speed, self.config.heading_gain * deviation)
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
