"""Wall following as published: a weighted sum of the raw infrared values (profile `thesis`).

Equations 3.8 to 3.14 and algorithm 5. It knows neither distances nor corners; what it does at them emerges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import Follow
from ..world.robot import Percept, WheelCommand

RIGHT_WEIGHTS = (10.0, 10.0, 5.0, 0.0, 0.0, -5.0, -10.0, 10.0)
"""Eq. 3.9 with eq. 3.11: what each infrared value adds to the right wheel; the left has the negatives."""


@dataclass(frozen=True, slots=True)
class ReactiveWallFollowingConfig:
    """Settings. Infrared values are raw, speeds in steps/s.

    bias: speed where nothing is near (233 is the 3 cm/s of table 4.1; algorithm 5 says 100). threshold: a
    wall is near beyond it (algorithm 5 has one but no figure). near: the side sensor's value beyond which
    `offsets` (for the diagonal, side and rear sensor) are taken off, so that the wall attracts. divisor: of
    the weighted sum.
    """

    bias: float = 233.0
    threshold: float = 200.0
    near: float = 300.0
    diagonal_offset: float = 100.0
    side_offset: float = 600.0
    rear_offset: float = 100.0
    divisor: float = 16.0


class Reacting(Enum):
    """CLOSE: some sensor sees a wall. CIRCLING: none does, so it circles toward the wall's side."""

    CIRCLING = "circling"
    CLOSE = "close"


class ReactiveWallFollowing(Behavior):
    """Maps infrared values to wheel speeds. Goal: `agent.goals.Follow`, its `start` and `turn` unused.

    The left side is the exact mirror image of the right one. Never finishes by itself.
    """

    name = "reactive-wall-following"
    priority = 10
    States = Reacting
    initial = Reacting.CIRCLING
    Config = ReactiveWallFollowingConfig
    transitions = (
        Transition("wall_close", Reacting.CIRCLING, Reacting.CLOSE),
        Transition("wall_gone", Reacting.CLOSE, Reacting.CIRCLING),
    )
    Goal = Follow
    example = Follow("right")
    config: ReactiveWallFollowingConfig
    goal: Follow

    def circling(self, percept: Percept, context: Context) -> Proposal:
        """Circles toward the wall's side until some sensor sees a wall."""
        return self._react(percept)

    def close(self, percept: Percept, context: Context) -> Proposal:
        """Eq. 3.12 with the wall's attraction."""
        return self._react(percept)

    def _react(self, percept: Percept) -> Proposal:
        right = self.goal.side == "right"
        values = percept.infrared if right else percept.infrared[::-1]
        close = any(value > self.config.threshold for value in values)
        if close is not (self.state is Reacting.CLOSE):
            self.fire("wall_close" if close else "wall_gone")
        near, far = self.wheels(values)
        command = WheelCommand(far, near) if right else WheelCommand(near, far)
        return Proposal(command, 1.0, self.state.value)

    def wheels(self, values: Sequence[float]) -> tuple[float, float]:
        """Speeds (steps/s) of the wheels on the wall's side and on the other, for a wall on the right.

        values: (8,) raw infrared; for a wall on the left in reverse order.
        """
        config = self.config
        if not any(value > config.threshold for value in values):
            return 0.5 * config.bias, config.bias
        shifted = list(values)
        if shifted[2] > config.near:
            shifted[1] -= config.diagonal_offset
            shifted[2] -= config.side_offset
            shifted[3] -= config.rear_offset
        drive = sum(w * v for w, v in zip(RIGHT_WEIGHTS, shifted, strict=True)) / config.divisor
        return config.bias + drive, config.bias - drive
