"""Arbitration by priority: the strongest layer that wants control has it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..fields import configured
from .mediator import NOBODY, Candidate, Decision


@dataclass(frozen=True, slots=True)
class PriorityConfig:
    """Options. hysteresis: how much more a rival of the same priority must want control to take it over.

    threshold: proposals with less activation count as not made.
    """

    hysteresis: float = 0.1
    threshold: float = 0.05


class PriorityMediator:
    """The strongest layer that wants control gets it; among equals, whoever has it keeps it.

    Section 3.2 gives the layers but no order: ours is in docs/decisions.
    """

    name = "priority"
    Config = PriorityConfig

    def __init__(self, config: PriorityConfig | None = None, **options: Any) -> None:
        """Options as a config or by name. Raises: ConfigError."""
        self.config: PriorityConfig = configured(f"mediator {self.name}", self.Config, config, options)

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """The decision: by priority, then activation (with a bonus for `previous`), then name."""
        threshold, hysteresis = self.config.threshold, self.config.hysteresis
        best: Candidate | None = None
        best_key: tuple[int, float] = (0, 0.0)
        for candidate in candidates:
            activation = candidate.proposal.activation
            if activation < threshold:
                continue
            if candidate.name == previous:
                activation += hysteresis
            key = (candidate.priority, activation)
            if best is None or key > best_key or (key == best_key and candidate.name < best.name):
                best, best_key = candidate, key
        if best is None:
            return NOBODY
        reason = best.proposal.reason
        if best.name != previous:
            reason = _why(best, candidates, reason)
        return Decision(best.name, best.proposal.command, reason)

    def reset(self) -> None:
        """It keeps no past."""


def _why(best: Candidate, candidates: Sequence[Candidate], reason: str) -> str:
    rivals = [f"{entry.name} ({entry.priority})" for entry in candidates if entry.name != best.name]
    over = f" over {', '.join(rivals)}" if rivals else ""
    return f"{reason or 'wants to'} [priority {best.priority}{over}]"
