"""Spiral: drives in a growing spiral, to look over an open place."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from tolman.agent import Behavior, Context, Proposal, Transition
from tolman.world.robot import Percept, WheelCommand


@dataclass(frozen=True, slots=True)
class SpiralConfig:
    """Settings. speed: steps/s. growth: m that the radius grows by in one turn. radius: m, where it ends."""

    speed: float = 200.0
    growth: float = 0.07
    radius: float = 0.3


@dataclass(frozen=True, slots=True)
class Wind:
    """What it is asked to do. side: "left" or "right", to which it turns."""

    side: Annotated[str, ("left", "right")] = "left"


class Spiral(Behavior):
    """Drives a spiral outwards and finishes at its rim."""

    class States(Enum):
        """WINDING: on the way outwards. DONE: at the rim."""

        WINDING = "winding"
        DONE = "done"

    name = "spiral"
    priority = 12
    initial = States.WINDING
    transitions = (Transition("arrive", States.WINDING, States.DONE),)
    Config = SpiralConfig
    Goal = Wind

    def on_reset(self) -> None:
        """Back to the spiral's middle."""
        self.radius = 0.05

    def winding(self, percept: Percept, context: Context) -> Proposal | None:
        """Drives a little straighter each tick, until it is at the rim."""
        self.radius += self.config.growth * abs(context.turn) / 6.2832
        if self.radius >= self.config.radius:
            self.fire("arrive")
            return None
        bend = 0.5 * context.geometry.track / self.radius
        inner, outer = self.config.speed * (1 - bend), self.config.speed * (1 + bend)
        left, right = (inner, outer) if self.goal.side == "left" else (outer, inner)
        return Proposal(WheelCommand(left, right), reason="winding outwards")

    def on_enter_done(self, context: Context) -> None:
        """That was the goal."""
        self.finish(True, "at the rim", result=self.radius)

    def done(self, percept: Percept, context: Context) -> Proposal | None:
        """Has nothing more to say."""
        return None
