"""Obstacle avoidance: the last reflex before the shell touches something (section 3.4.1, eq. 3.9)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.perception.infrared import raw_value
from ..world.robot import (
    LEFT_DIAGONAL,
    LEFT_FRONT,
    RIGHT_DIAGONAL,
    RIGHT_FRONT,
    Percept,
    WheelCommand,
)

LEFT_WEIGHTS = (-10.0, -10.0, -5.0, 0.0, 0.0, 5.0, 10.0, 10.0)
"""Eq. 3.9: what each infrared value adds to the left wheel; the right wheel has the negatives."""


@dataclass(frozen=True, slots=True)
class ObstacleAvoidanceConfig:
    """Settings. Distances are from the rim, in m; speeds in steps/s.

    front: nearer than this ahead is too close. diagonal: the same for the two diagonal sensors.
    release: how many times farther it must be before the reflex ends. speed: at most, in turning.
    least: at least, where the weighted sum cancels out. gain: eq. 3.12 divides by 16.
    """

    front: float = 0.008
    diagonal: float = 0.004
    release: float = 1.5
    speed: float = 300.0
    least: float = 100.0
    gain: float = 1.0 / 16.0


_SPIN = 100.0
"""Radians a meter beyond which a motion counts as turning in place: a circle of 1 cm."""


class ObstacleAvoidance(Behavior):
    """Turns in place, away from what is nearest, until there is room ahead.

    Speeds are eq. 3.12 with the weights of eq. 3.9 and a bias of zero: a round robot that turns in place
    hits nothing. The side is kept until it is over, as the sum changes its sign in a corner; where a wall
    straight ahead makes it cancel out, `least` breaks the tie. At the distance at which walls are followed
    (2 cm) nothing is near enough to wake it.
    """

    class States(Enum):
        """CLEAR: room ahead. TURNING_LEFT, TURNING_RIGHT: making room."""

        CLEAR = "clear"
        TURNING_LEFT = "turning left"
        TURNING_RIGHT = "turning right"

    name = "obstacle-avoidance"
    priority = 50
    initial = States.CLEAR
    transitions = (
        Transition("obstacle_on_right", States.CLEAR, States.TURNING_LEFT),
        Transition("obstacle_on_left", States.CLEAR, States.TURNING_RIGHT),
        Transition("cleared", (States.TURNING_LEFT, States.TURNING_RIGHT), States.CLEAR),
    )
    Config = ObstacleAvoidanceConfig
    restarts = True

    def on_start(self, context: Context) -> None:
        """Thresholds of the infrared values, (front, diagonal): where the reflex begins and where it ends."""
        geometry, config = context.geometry, self.config
        front, diagonal = config.front * config.release, config.diagonal * config.release
        self._begin = raw_value(geometry, config.front), raw_value(geometry, config.diagonal)
        self._end = raw_value(geometry, front), raw_value(geometry, diagonal)

    def clear(self, percept: Percept, context: Context) -> Proposal | None:
        """Silent while nothing is too near; else begins to turn away from it."""
        infrared = percept.infrared
        if not _is_near(infrared, self._begin):
            return None
        if abs(context.turn) > _SPIN * abs(context.distance):
            # Another behavior turns in place: a round robot hits nothing by that, and wants to finish.
            return None
        self.fire("obstacle_on_left" if weighted(infrared) * self.config.gain > 0.0 else "obstacle_on_right")
        return self._turn(infrared)

    def turning_left(self, percept: Percept, context: Context) -> Proposal | None:
        """Turns left until there is room ahead, and some to spare."""
        if _is_near(percept.infrared, self._end):
            return self._turn(percept.infrared)
        self.fire("cleared")
        return None

    def turning_right(self, percept: Percept, context: Context) -> Proposal | None:
        """The same, to the right."""
        return self.turning_left(percept, context)

    def _turn(self, infrared: Sequence[float]) -> Proposal:
        drive = abs(weighted(infrared) * self.config.gain)
        speed = max(self.config.least, min(self.config.speed, drive))
        left = -speed if self.state is self.States.TURNING_LEFT else speed
        return Proposal(WheelCommand(left, -left), 1.0, "too close ahead")


def _is_near(infrared: Sequence[float], limits: tuple[float, float]) -> bool:
    front, diagonal = limits
    return (
        infrared[RIGHT_FRONT] > front
        or infrared[LEFT_FRONT] > front
        or infrared[RIGHT_DIAGONAL] > diagonal
        or infrared[LEFT_DIAGONAL] > diagonal
    )


def weighted(infrared: Sequence[float]) -> float:
    """The sum of eq. 3.12 for the left wheel, without bias and divisor; positive turns right."""
    return sum(weight * value for weight, value in zip(LEFT_WEIGHTS, infrared, strict=True))
