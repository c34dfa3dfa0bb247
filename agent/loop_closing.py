"""One boundary while it is being mapped: which corners are nodes, and when it has come round.

A corner that may be an earlier one is not made a node: the corners after it must agree with those that
followed then. `Circuit` keeps what is undecided, so that a mapper only acts on what is certain. A boundary
that stands apart from the first has a circuit of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from .boundary import BoundaryTrace, ClosingConfig, Corner

if TYPE_CHECKING:
    from .events import CornerReached


class Finding(Enum):
    """What the corner at hand is."""

    NEW = "new"
    MAYBE_KNOWN = "maybe known"
    CLOSED = "closed"


@dataclass(frozen=True, slots=True)
class Met:
    """A corner met: its index in the trace, and the event that told of it."""

    index: int
    event: CornerReached


@dataclass(frozen=True, slots=True)
class Judgement:
    """finding: what the corner at hand is. rejected: corners taken for known ones that are new after all."""

    finding: Finding
    rejected: tuple[Met, ...] = ()


class Circuit:
    """Follows one boundary corner by corner, until it has come round.

    trace: its shape. node_of: index in the trace -> node of the map, filled in by the mapper.
    """

    def __init__(self, config: ClosingConfig) -> None:
        """Starts with no corner."""
        self.config = config
        self.trace = BoundaryTrace(config)
        self.node_of: dict[int, int] = {}
        self.candidate = -1
        self.pending: list[Met] = []

    def reach(self, event: CornerReached) -> Judgement:
        """Takes the next corner. After CLOSED `pending` are the corners met again, from `candidate` on."""
        met = Met(self.trace.reach(event.kind, event.path_length), event)
        rejected: tuple[Met, ...] = ()
        if self.pending:
            expected = self.candidate + len(self.pending)
            if self.trace.agrees(expected, event.kind, event.path_length):
                self.pending.append(met)
                closed = len(self.pending) > self.config.confirmations
                return Judgement(Finding.CLOSED if closed else Finding.MAYBE_KNOWN)
            rejected, self.pending = tuple(self.pending), []
        return Judgement(self._look_up(met, {each.index for each in rejected}), rejected)

    def _look_up(self, met: Met, rejected: set[int]) -> Finding:
        candidate = self.trace.candidate()
        if candidate is None or not (candidate in self.node_of or candidate in rejected):
            return Finding.NEW
        self.candidate, self.pending = candidate, [met]
        return Finding.MAYBE_KNOWN

    @property
    def known(self) -> list[int]:
        """Nodes of the loop that has closed, in the order in which they are met, the first one first."""
        return [self.node_of[index] for index in sorted(self.node_of) if index >= self.candidate]

    def state(self) -> dict[str, Any]:
        """What has to be kept to go on, as JSON; nothing is undecided when a node is committed."""
        return {
            "corners": [[corner.kind, corner.length, corner.turn] for corner in self.trace.corners],
            "nodes": sorted(self.node_of.items()),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        self.trace.corners = [Corner(*corner) for corner in state["corners"]]
        self.node_of = {int(index): int(node) for index, node in state["nodes"]}
