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
    RobotGeometry,
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

    def on_reset(self) -> None:
        """Forgets the thresholds: another robot may follow."""
        self._limits: tuple[float, float, float, float] | None = None

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """None while nothing is too near; else a turn in place."""
        limits = self._limits
        if limits is None:
            limits = self._limits = self._thresholds(context.geometry)
        infrared = percept.infrared
        clear = self.state is self.States.CLEAR
        front, diagonal = limits[:2] if clear else limits[2:]
        near = (
            infrared[RIGHT_FRONT] > front
            or infrared[LEFT_FRONT] > front
            or infrared[RIGHT_DIAGONAL] > diagonal
            or infrared[LEFT_DIAGONAL] > diagonal
        )
        if not near:
            if not clear:
                self.fire("cleared")
            return None
        if clear and abs(context.turn) > _SPIN * abs(context.distance):
            # Another behavior turns in place: a round robot hits nothing by that, and wants to finish.
            return None
        drive = weighted(infrared) * self.config.gain
        if clear:
            self.fire("obstacle_on_left" if drive > 0.0 else "obstacle_on_right")
        return Proposal(self._turn(abs(drive)), 1.0, "too close ahead")

    def _turn(self, drive: float) -> WheelCommand:
        speed = max(self.config.least, min(self.config.speed, drive))
        if self.state is self.States.TURNING_LEFT:
            return WheelCommand(-speed, speed)
        return WheelCommand(speed, -speed)

    def _thresholds(self, geometry: RobotGeometry) -> tuple[float, float, float, float]:
        config = self.config
        return (
            raw_value(geometry, config.front),
            raw_value(geometry, config.diagonal),
            raw_value(geometry, config.front * config.release),
            raw_value(geometry, config.diagonal * config.release),
        )


def weighted(infrared: Sequence[float]) -> float:
    """The sum of eq. 3.12 for the left wheel, without bias and divisor; positive turns right."""
    return sum(weight * value for weight, value in zip(LEFT_WEIGHTS, infrared, strict=True))
