"""Takes a four-directional image where the robot stands, by path integration alone (section 3.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

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
    example_goal = LookAround()
    config: LookAroundConfig

    def on_reset(self) -> None:
        """Forgets what it saw."""
        self._remaining = 0.0
        self._wanted = 0
        self._views: list[Image] = []

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes a `LookAround` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, LookAround):
            raise TypeError(f"{self.name} needs a LookAround goal, not {goal!r}")
        self._remaining = goal.turn
        self._wanted = _DIRECTIONS if goal.views else 0

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of turning, or one look."""
        if self.state is Looking.LOOK:
            self._views.append(context.look())
            self._remaining += 0.5 * math.pi
            self.fire("next")
            return Proposal(STOP, 1.0, "looking")
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
