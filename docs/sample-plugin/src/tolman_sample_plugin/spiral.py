"""Spiral: drives in a growing spiral, to look over an open place."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from tolman.agent import Behavior, Context, Proposal, Transition
from tolman.world.robot import Percept, WheelCommand


@dataclass(frozen=True, slots=True)
class SpiralConfig:
    """Settings. speed: steps/s. growth: m that the radius grows by in one turn. radius: m, where it ends."""

    speed: float = 200.0
    growth: float = 0.07
    radius: float = 0.3


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

    def on_reset(self) -> None:
        """Back to the spiral's middle."""
        self.radius = 0.05

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """A little straighter each tick."""
        self.radius += self.config.growth * abs(context.turn) / 6.2832
        if self.radius >= self.config.radius:
            if self.state is self.States.WINDING:
                self.fire("arrive")
            self.finish(True, "at the rim", result=self.radius)
            return None
        bend = 0.5 * context.geometry.track / self.radius
        speed = self.config.speed
        return Proposal(WheelCommand(speed * (1 - bend), speed * (1 + bend)), reason="winding outwards")
