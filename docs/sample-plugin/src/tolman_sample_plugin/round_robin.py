"""Round robin: everybody drives in turn for a while. To show how a mediator is made, not to drive well."""

from __future__ import annotations

from collections.abc import Sequence

from tolman.agent import Candidate, Decision
from tolman.world.robot import STOP


class RoundRobin:
    """Gives control to each candidate for `ticks` ticks, in the order of their names."""

    name = "round-robin"

    def __init__(self, ticks: int = 30) -> None:
        """ticks: how long each drives."""
        self.ticks = ticks
        self.reset()

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """The one whose turn it is, or the next if that one has nothing to say."""
        if not candidates:
            return Decision(None, STOP, "nobody proposes")
        ordered = sorted(candidates, key=lambda candidate: candidate.name)
        current = [candidate for candidate in ordered if candidate.name == previous]
        if current and self._used < self.ticks:
            self._used += 1
            return Decision(current[0].name, current[0].proposal.command, "still its turn")
        self._used = 1
        later = [candidate for candidate in ordered if previous is None or candidate.name > previous]
        chosen = (later or ordered)[0]
        return Decision(chosen.name, chosen.proposal.command, "its turn")

    def reset(self) -> None:
        """Begins again."""
        self._used = 0
