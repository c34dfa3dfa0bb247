"""Wander: drives about at random, turning away from what comes near; the layer to put others on top of."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..world.robot import LEFT_DIAGONAL, LEFT_FRONT, RIGHT_DIAGONAL, RIGHT_FRONT, Percept, WheelCommand


@dataclass(frozen=True, slots=True)
class WanderConfig:
    """Settings. speed, turn_speed: steps/s. clearance: m from the rim at which it turns away.

    leg: mean distance (m) driven straight before it turns anyway.
    """

    speed: float = 300.0
    turn_speed: float = 200.0
    clearance: float = 0.025
    leg: float = 0.3


class Wander(Behavior):
    """Straight legs of random length with turns in place of random angle between them.

    Always proposes, weakly: whoever wants something in particular goes first.
    """

    class States(Enum):
        """STRAIGHT: driving a leg. TURNING: turning in place to the next heading."""

        STRAIGHT = "straight"
        TURNING = "turning"

    name = "wander"
    priority = 5
    initial = States.STRAIGHT
    transitions = (
        Transition("turn", States.STRAIGHT, States.TURNING),
        Transition("turned", States.TURNING, States.STRAIGHT),
    )
    Config = WanderConfig

    def on_reset(self) -> None:
        """No leg is under way."""
        self._left_to_drive: float | None = None
        self._left_to_turn = 0.0
        self._side = 1.0

    def straight(self, percept: Percept, context: Context) -> Proposal:
        """Drives a leg to its end, or until something is near."""
        config = self.config
        if self._left_to_drive is None:
            self._left_to_drive = float(context.rng.exponential(config.leg))
        self._left_to_drive -= abs(context.distance)
        blocked = self._blocked(percept, context)
        if blocked or self._left_to_drive <= 0.0:
            self._plan_turn(percept, context, blocked)
            self.fire("turn")
            return Proposal(WheelCommand(0.0, 0.0), 0.3, "about to turn")
        return Proposal(WheelCommand(config.speed, config.speed), 0.3, "driving a leg")

    def turning(self, percept: Percept, context: Context) -> Proposal:
        """Turns by the angle that was drawn, and on until there is room ahead."""
        self._left_to_turn -= abs(context.turn)
        if self._left_to_turn <= 0.0 and not self._blocked(percept, context):
            self._left_to_drive = float(context.rng.exponential(self.config.leg))
            self.fire("turned")
        speed = self._side * self.config.turn_speed
        return Proposal(WheelCommand(-speed, speed), 0.3, "turning to a new heading")

    def _plan_turn(self, percept: Percept, context: Context, blocked: bool) -> None:
        infrared = percept.infrared
        right = infrared[RIGHT_FRONT] + infrared[RIGHT_DIAGONAL]
        left = infrared[LEFT_FRONT] + infrared[LEFT_DIAGONAL]
        away = 1.0 if right >= left else -1.0
        self._side = away if blocked else (1.0 if context.rng.random() < 0.5 else -1.0)
        self._left_to_turn = float(context.rng.uniform(0.25 * math.pi, 0.75 * math.pi))

    def _blocked(self, percept: Percept, context: Context) -> bool:
        distance = context.geometry.infrared_distance
        ahead = (RIGHT_DIAGONAL, RIGHT_FRONT, LEFT_FRONT, LEFT_DIAGONAL)
        nearest = distance(max(percept.infrared[sensor] for sensor in ahead))
        return bool(nearest < self.config.clearance)
