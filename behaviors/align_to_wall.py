"""Align to wall: turns in place until the wall beside the robot is parallel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import AlignToWall
from ..agent.motion import spin_command
from ..agent.perception.side_view import SideView
from ..world.robot import STOP, Percept


@dataclass(frozen=True, slots=True)
class AligningConfig:
    """Settings. samples: ticks of standing that one measurement averages. tolerance: rad that will do.

    rounds: measurements before it gives up. turn_speed: steps/s. blind: rad taken for the angle where only
    one of the two sensors at the side sees the wall.
    """

    samples: int = 12
    tolerance: float = 0.02
    rounds: int = 6
    turn_speed: float = 150.0
    blind: float = 0.2


class Aligning(Enum):
    """MEASURING: standing, averaging the wall's direction. TURNING: turning by what was measured."""

    MEASURING = "measuring"
    TURNING = "turning"


class AlignToWallBehavior(Behavior):
    """Turns in place until a wall is parallel. Goal: `agent.goals.AlignToWall`.

    Result: the remaining angle (rad) as measured last. It fails where the side and diagonal sensors see no
    wall, or where it is never within the tolerance.
    """

    name = "align-to-wall"
    priority = 40
    States = Aligning
    initial = Aligning.MEASURING
    Config = AligningConfig
    transitions = (
        Transition("turn", Aligning.MEASURING, Aligning.TURNING),
        Transition("measure", Aligning.TURNING, Aligning.MEASURING),
    )
    Goal = AlignToWall
    config: AligningConfig
    goal: AlignToWall

    def on_reset(self) -> None:
        """Forgets what was measured."""
        self._angles: list[float] = []
        self._seen = 0
        self._rounds = 0
        self._remaining = 0.0

    def on_start(self, context: Context) -> None:
        """Looks at the goal's side."""
        self._view = SideView(context.geometry, self.goal.side)

    def measuring(self, percept: Percept, context: Context) -> Proposal:
        """Stands still until it has seen enough of the wall."""
        if context.in_control or self._seen == 0:
            self._measure(self._view, percept)
        if self.finished:
            return Proposal(STOP, reason=self.reason)
        if self.state is Aligning.TURNING:
            return self._spin(context)
        return Proposal(STOP, reason="measuring the wall's direction")

    def turning(self, percept: Percept, context: Context) -> Proposal:
        """Turns by what was measured."""
        self._remaining -= context.turn
        return self._spin(context)

    def _measure(self, view: SideView, percept: Percept) -> None:
        view.read(percept)
        wall = view.side_wall()
        if wall is not None:
            self._angles.append(wall[1])
        elif view.side < math.inf:
            self._angles.append(self.config.blind)
        elif view.diagonal < math.inf:
            self._angles.append(-self.config.blind)
        self._seen += 1
        if self._seen < self.config.samples:
            return
        angles, self._angles, self._seen = self._angles, [], 0
        if 2 * len(angles) < self.config.samples:
            self.finish(False, "no wall at the side")
            return
        angle = math.fsum(angles) / len(angles)
        self._rounds += 1
        if abs(angle) <= self.config.tolerance:
            self.finish(True, "parallel to the wall", result=angle)
        elif self._rounds >= self.config.rounds:
            self.finish(
                False, f"still {math.degrees(angle):.1f} deg off after {self._rounds} rounds", result=angle
            )
        else:
            self._remaining = -angle * view.sign
            self.fire("turn")

    def _spin(self, context: Context) -> Proposal:
        if abs(self._remaining) < 0.25 * self.config.tolerance:
            self.fire("measure")
            return Proposal(STOP, reason="turned")
        command = spin_command(context.geometry, self._remaining, self.config.turn_speed)
        return Proposal(command, reason="turning parallel")
