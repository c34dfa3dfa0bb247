"""The mediator: of all proposals in a tick it picks the one that drives, and says why (section 3.2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ...world.robot import STOP, WheelCommand
from ..behavior import Proposal


class Candidate(NamedTuple):
    """One behavior's proposal, with what the mediator needs to weigh it. Higher priority is stronger."""

    name: str
    priority: int
    proposal: Proposal


@dataclass(frozen=True, slots=True)
class Decision:
    """Who drives, how, and why."""

    winner: str | None
    command: WheelCommand
    reason: str


NOBODY = Decision(None, STOP, "nobody proposes")


class Mediator(Protocol):
    """A strategy of arbitration. Must be a pure function of what it was given and of its own past."""

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """Picks from the candidates (may be none); `previous` drove in the last tick. Once a tick."""

    def reset(self) -> None:
        """Forgets its past."""


class PriorityMediator:
    """The strongest layer that wants control gets it; among equals, whoever has it keeps it.

    hysteresis: how much more a rival of the same priority must want control (activation) to take it over.
    Section 3.2 gives the layers but no order: ours is in docs/decisions.
    """

    name = "priority"

    def __init__(self, hysteresis: float = 0.1, threshold: float = 0.05) -> None:
        """threshold: proposals with less activation count as not made."""
        self.hysteresis = hysteresis
        self.threshold = threshold

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """The decision: by priority, then activation (with a bonus for `previous`), then name."""
        best: Candidate | None = None
        best_key: tuple[int, float] = (0, 0.0)
        for candidate in candidates:
            activation = candidate.proposal.activation
            if activation < self.threshold:
                continue
            if candidate.name == previous:
                activation += self.hysteresis
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
