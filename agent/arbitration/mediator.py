"""The mediator: of all proposals in a tick it picks the one that drives, and says why (section 3.2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ...world.robot import STOP, WheelCommand
from ..declarations import Proposal


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
