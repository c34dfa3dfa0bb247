"""Other strategies of arbitration than the thesis's priorities: a weighted blend, and subsumption."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...world.robot import STOP, WheelCommand
from ..behavior import Proposal
from .mediator import NOBODY, Candidate, Decision


class BlendMediator:
    """The mean of all proposed speeds, weighted with activation times priority; a reflex is not blended.

    reflex: proposals of this priority or more drive alone, as half an evasion is none.
    The winner is who has the largest share, as events need one name.
    """

    name = "blend"

    def __init__(self, reflex: int = 50, threshold: float = 0.05) -> None:
        """threshold: proposals with less activation count as not made."""
        self.reflex = reflex
        self.threshold = threshold

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """The blended command. Priorities below 1 count as 1."""
        wanting = [entry for entry in candidates if entry.proposal.activation >= self.threshold]
        if not wanting:
            return NOBODY
        strongest = min(wanting, key=lambda entry: (-entry.priority, -entry.proposal.activation, entry.name))
        if strongest.priority >= self.reflex or len(wanting) == 1:
            return Decision(strongest.name, strongest.proposal.command, strongest.proposal.reason)
        return _blend(wanting)

    def reset(self) -> None:
        """It keeps no past."""


def _blend(wanting: Sequence[Candidate]) -> Decision:
    weights = [max(1, entry.priority) * entry.proposal.activation for entry in wanting]
    total = sum(weights)
    pairs = list(zip(wanting, weights, strict=True))
    left = sum(weight * entry.proposal.command.left for entry, weight in pairs) / total
    right = sum(weight * entry.proposal.command.right for entry, weight in pairs) / total
    winner = min(pairs, key=lambda pair: (-pair[1], pair[0].name))[0]
    shares = ", ".join(f"{entry.name} {weight / total:.0%}" for entry, weight in pairs)
    return Decision(winner.name, WheelCommand(left, right), f"blend of {shares}")


@dataclass(frozen=True, slots=True)
class Wire:
    """One side-tap of a subsumption network: while `source` proposes, it acts on `target`.

    inhibit: True takes the target's output away; False (suppress) replaces it with the source's.
    """

    source: str
    target: str
    inhibit: bool = False


_HELD = Proposal(STOP, 1.0, "held after it fell silent")


class SubsumptionMediator:
    """Brooks's network: layers wired by suppression and inhibition (section 3.2, figure 3.2 b).

    Without wires each layer suppresses all weaker ones. `hold_ticks` after it fell silent a layer still
    acts on the others, with the wheels at rest: what it last wanted must not drive on without it.
    """

    name = "subsumption"

    def __init__(self, wires: Sequence[Wire] = (), hold_ticks: int = 0) -> None:
        """wires: explicit side-taps; a layer that no wire reaches competes by priority as usual."""
        self.wires = tuple(wires)
        self.hold_ticks = hold_ticks
        self._recent: dict[str, tuple[int, Candidate]] = {}

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """Who is left after all wires took effect; the strongest of them drives."""
        outputs = self._held(candidates)
        notes: dict[str, str] = {}
        inhibited = {wire.target for wire in self.wires if wire.inhibit and wire.source in outputs}
        effective: dict[str, Candidate] = {
            name: entry for name, entry in outputs.items() if name not in inhibited
        }
        for wire in self.wires:
            source = outputs.get(wire.source)
            if wire.inhibit or source is None or wire.target not in effective:
                continue
            effective.pop(wire.target)
            if wire.source not in inhibited:
                notes[wire.source] = f" (suppresses {wire.target})"
        if not effective:
            return NOBODY
        best = min(effective.values(), key=lambda entry: (-entry.priority, entry.name))
        reason = best.proposal.reason + notes.get(best.name, "")
        return Decision(best.name, best.proposal.command, reason)

    def reset(self) -> None:
        """Forgets who proposed lately."""
        self._recent.clear()

    def _held(self, candidates: Sequence[Candidate]) -> Mapping[str, Candidate]:
        now = {entry.name: entry for entry in candidates}
        aged = {
            name: (left - 1, entry._replace(proposal=_HELD))
            for name, (left, entry) in self._recent.items()
            if left > 0 and name not in now
        }
        self._recent = aged | {name: (self.hold_ticks, entry) for name, entry in now.items()}
        return {name: entry for name, (_, entry) in self._recent.items()}
