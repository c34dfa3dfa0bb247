"""A blend: the mean of all proposed speeds, weighted with activation times priority."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...world.robot import WheelCommand
from ..fields import configured
from .mediator import NOBODY, Candidate, Decision


@dataclass(frozen=True, slots=True)
class BlendConfig:
    """Options. reflex: proposals of this priority or more drive alone, as half an evasion is none.

    threshold: proposals with less activation count as not made. sharpness: the power to which weights are
    raised; the larger, the more the strongest has its way.
    """

    reflex: int = 50
    threshold: float = 0.05
    sharpness: float = 1.0


class BlendMediator:
    """The mean of all proposed speeds, weighted with activation times priority; a reflex is not blended.

    The winner is who has the largest share, as events need one name.
    """

    name = "blend"
    Config = BlendConfig

    def __init__(self, config: BlendConfig | None = None, **options: Any) -> None:
        """Options as a config or by name. Raises: ConfigError."""
        self.config: BlendConfig = configured(f"mediator {self.name}", self.Config, config, options)

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """The blended command. Priorities below 1 count as 1."""
        wanting = [entry for entry in candidates if entry.proposal.activation >= self.config.threshold]
        if not wanting:
            return NOBODY
        strongest = min(wanting, key=lambda entry: (-entry.priority, -entry.proposal.activation, entry.name))
        if strongest.priority >= self.config.reflex or len(wanting) == 1:
            return Decision(strongest.name, strongest.proposal.command, strongest.proposal.reason)
        return _blend(wanting, self.config.sharpness)

    def reset(self) -> None:
        """It keeps no past."""


def _blend(wanting: Sequence[Candidate], sharpness: float) -> Decision:
    weights = [(max(1, entry.priority) * entry.proposal.activation) ** sharpness for entry in wanting]
    total = sum(weights)
    pairs = list(zip(wanting, weights, strict=True))
    left = sum(weight * entry.proposal.command.left for entry, weight in pairs) / total
    right = sum(weight * entry.proposal.command.right for entry, weight in pairs) / total
    winner = min(pairs, key=lambda pair: (-pair[1], pair[0].name))[0]
    shares = ", ".join(f"{entry.name} {weight / total:.0%}" for entry, weight in pairs)
    return Decision(winner.name, WheelCommand(left, right), f"blend of {shares}")
