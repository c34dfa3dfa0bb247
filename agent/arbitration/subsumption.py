"""Subsumption: layers wired by suppression and inhibition (section 3.2, figure 3.2 b)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...world.robot import STOP
from ..declarations import Proposal
from ..fields import configured
from .mediator import NOBODY, Candidate, Decision


@dataclass(frozen=True, slots=True)
class Wire:
    """One side-tap of a subsumption network: while `source` proposes, it acts on `target`.

    inhibit: True takes the target's output away; False (suppress) replaces it with the source's.
    """

    source: str
    target: str
    inhibit: bool = False


@dataclass(frozen=True, slots=True)
class SubsumptionConfig:
    """Options. wires: side-taps; a layer that no wire reaches competes by priority as usual.

    hold_ticks: how long a layer still acts on the others after it fell silent.
    """

    wires: tuple[Wire, ...] = ()
    hold_ticks: int = 0


_HELD = Proposal(STOP, 1.0, "held after it fell silent")


class SubsumptionMediator:
    """Brooks's network: layers wired by suppression and inhibition (section 3.2, figure 3.2 b).

    Without wires each layer suppresses all weaker ones. `hold_ticks` after it fell silent a layer still
    acts on the others, with the wheels at rest: what it last wanted must not drive on without it.
    """

    name = "subsumption"
    Config = SubsumptionConfig

    def __init__(self, config: SubsumptionConfig | None = None, **options: Any) -> None:
        """Options as a config or by name. Raises: ConfigError."""
        self.config: SubsumptionConfig = configured(f"mediator {self.name}", self.Config, config, options)
        self._recent: dict[str, tuple[int, Candidate]] = {}

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """Who is left after all wires took effect; the strongest of them drives."""
        outputs = self._held(candidates)
        notes: dict[str, str] = {}
        inhibited = {wire.target for wire in self.config.wires if wire.inhibit and wire.source in outputs}
        effective: dict[str, Candidate] = {
            name: entry for name, entry in outputs.items() if name not in inhibited
        }
        for wire in self.config.wires:
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
        self._recent = aged | {name: (self.config.hold_ticks, entry) for name, entry in now.items()}
        return {name: entry for name, (_, entry) in self._recent.items()}
