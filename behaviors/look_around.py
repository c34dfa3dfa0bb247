"""Takes a four-directional image where the robot stands, by path integration alone (section 3.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import LookAround
from ..agent.motion import spin_command
from ..world.robot import STOP, Image, Percept

_DIRECTIONS = 4


@dataclass(frozen=True, slots=True)
class LookAroundConfig:
    """Settings. turn_speed: of each wheel, steps/s. tolerance: of each direction, rad."""

    turn_speed: float = 300.0
    tolerance: float = 0.004


class Looking(Enum):
    """TURN: toward the next direction. LOOK: standing there."""

    TURN = "turn"
    LOOK = "look"


class LookAroundBehavior(Behavior):
    """Turns, looks, turns back. Goal: `agent.goals.LookAround`.

    Result: (4, 16, 16) luminance in [0, 1], views ahead, left, behind, right; None without views.
    """

    name = "look-around"
    priority = 30
    States = Looking
    initial = Looking.TURN
    Config = LookAroundConfig
    transitions = (
        Transition("there", Looking.TURN, Looking.LOOK),
        Transition("next", Looking.LOOK, Looking.TURN),
    )
    Goal = LookAround
    config: LookAroundConfig
    goal: LookAround

    def on_reset(self) -> None:
        """Forgets what it saw."""
        self._views: list[Image] = []

    def on_start(self, context: Context) -> None:
        """Takes how far to turn from the goal."""
        self._remaining = self.goal.turn
        self._wanted = _DIRECTIONS if self.goal.views else 0

    def turn(self, percept: Percept, context: Context) -> Proposal:
        """Turns toward the next direction; the last is the one it began with."""
        self._remaining -= context.turn
        if abs(self._remaining) > self.config.tolerance:
            command = spin_command(context.geometry, self._remaining, self.config.turn_speed)
            return Proposal(command, 1.0, "turning")
        if len(self._views) < self._wanted:
            self.fire("there")
        else:
            views = np.array(self._views, dtype=np.float32) if self._wanted else None
            self.finish(True, f"{len(self._views)} views", views)
        return Proposal(STOP, 1.0, "there")

    def look(self, percept: Percept, context: Context) -> Proposal:
        """Takes one image."""
        self._views.append(context.look())
        self._remaining += 0.5 * math.pi
        self.fire("next")
        return Proposal(STOP, 1.0, "looking")
