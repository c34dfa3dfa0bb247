"""One boundary while it is being mapped: which corners are nodes, and when it has come round.

A corner that may be an earlier one is not made a node: the corners after it must agree with those that
followed then. Several corners may be the one at which the loop closes; each is pursued until the corners
after it speak against it. `LoopDetector` keeps what is undecided, so that a mapper only acts on what is
certain. A boundary that stands apart from the first has a loop detector of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import Any

from ..codec import decode, encode, reinstate, snapshot
from ..events import CornerReached
from .trace import BEND, WEAK, BoundaryTrace, ClosingConfig, Corner, WallSegment

_KEPT = ("_undecided", "_hypotheses")


class Finding(Enum):
    """What the corner at hand is."""

    NEW = "new"
    MAYBE_KNOWN = "maybe known"
    CLOSED = "closed"


@dataclass(frozen=True, slots=True)
class CornerObservation:
    """A corner met: its index in the trace, the event that told of it, and the earlier corner it seems."""

    index: int
    event: CornerReached
    known: int | None = None


@dataclass(frozen=True, slots=True)
class Judgement:
    """finding: what the corner at hand is. rejected: corners taken for known ones that are new after all."""

    finding: Finding
    rejected: tuple[CornerObservation, ...] = ()


@dataclass(slots=True)
class LoopHypothesis:
    """Corners that seem to be earlier ones, from the one at which the loop would have closed.

    past: how far (m) that one lies beyond the node it is taken for; bends are not met at the same place.
    """

    corners: list[CornerObservation]
    past: float = 0.0

    @property
    def agreed(self) -> int:
        """How many corners after the first were known."""
        return sum(met.known is not None for met in self.corners) - 1


class LoopDetector:
    """Follows one boundary corner by corner, until it has come round.

    trace: its shape. node_of: index in the trace -> node of the map, filled in by the mapper. closing: how
    the loop closes, once it has.
    """

    def __init__(self, config: ClosingConfig) -> None:
        """Starts with no corner."""
        self.config = config
        self.trace = BoundaryTrace(config)
        self.node_of: dict[int, int] = {}
        self.closing: LoopHypothesis | None = None
        self._hypotheses: list[LoopHypothesis] = []
        self._undecided: list[CornerObservation] = []

    def reach(self, event: CornerReached, way: WallSegment | None = None, bends: bool = True) -> Judgement:
        """Takes the next corner, and the way to it if that is not straight.

        bends: whether path integration is good enough to tell the bends of a wall without corners apart.
        """
        met = CornerObservation(self.trace.reach(event.kind, event.path_length, way), event)
        self._undecided.append(met)
        self._hypotheses = [each for each in self._hypotheses if self._leads_on(each, met)]
        candidate = self.trace.candidate(bends)
        if candidate is not None and self._is_place(candidate):
            past = self.trace.past(candidate)
            self._hypotheses.append(LoopHypothesis([replace(met, known=candidate)], past))
        if not self._hypotheses:
            new, self._undecided = tuple(self._undecided[:-1]), []
            return Judgement(Finding.NEW, new)
        first = self._hypotheses[0]
        new = tuple(each for each in self._undecided if each.index < first.corners[0].index)
        self._undecided = self._undecided[len(new) :]
        if first.agreed < self.config.confirmations:
            return Judgement(Finding.MAYBE_KNOWN, new)
        self.closing = first
        return Judgement(Finding.CLOSED, new)

    def _is_place(self, index: int) -> bool:
        """Whether corner `index` is a node, or becomes one unless the loop closes before."""
        return index in self.node_of or any(index == each.index for each in self._undecided)

    def _leads_on(self, hypothesis: LoopHypothesis, met: CornerObservation) -> bool:
        """Whether a hypothesis may be right with this corner too, which it then has."""
        event, first = met.event, hypothesis.corners[0]
        *_, last = (each for each in hypothesis.corners if each.known is not None)
        assert last.known is not None
        since = sum(each.event.path_length for each in hypothesis.corners if each.index > last.index)
        length = event.path_length + since
        if last is first:
            length += hypothesis.past
        known = self.trace.onward(last.known, event.kind, length)
        hypothesis.corners.append(replace(met, known=known))
        corners = self.trace.corners[first.known or 0].kind != BEND
        return known is not None or _may_be_missed(event, corners)

    # --- once it has closed ----------------------------------------------------------------------------

    def _closed(self) -> LoopHypothesis:
        if self.closing is None:
            raise RuntimeError("the loop has not closed yet")
        return self.closing

    @property
    def candidate(self) -> int:
        """The corner at which the loop has closed, as it was met first."""
        return self._closed().corners[0].known or 0

    @property
    def closing_length(self) -> float:
        """Meters from the corner before the one at which the loop has closed, to that one as it was first."""
        closing = self._closed()
        return closing.corners[0].event.path_length - closing.past

    def driven_again(self) -> list[tuple[int, int, float]]:
        """Arcs driven once more while the closing was confirmed: node, node, m."""
        again = []
        for before, met in pairwise(self._closed().corners):
            bent = BEND in (before.event.kind, met.event.kind)
            if before.known is None or met.known != before.known + 1 or bent:
                continue
            if before.known in self.node_of and met.known in self.node_of:
                nodes = self.node_of[before.known], self.node_of[met.known]
                again.append((*nodes, met.event.path_length))
        return again

    @property
    def here(self) -> int:
        """The node of the last corner met."""
        corners = self._closed().corners
        count = corners[0].index - self.candidate
        return self.node_of[self.candidate + ((corners[-1].known or 0) - self.candidate) % count]

    def state(self) -> dict[str, Any]:
        """What has to be kept to go on, as JSON."""
        return {
            **snapshot(self, _KEPT),
            "corners": encode(self.trace.corners),
            "nodes": sorted(self.node_of.items()),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        reinstate(self, _KEPT, state, CornerObservation, LoopHypothesis)
        self.trace.corners = decode(state["corners"], Corner, WallSegment)
        self.node_of = {int(index): int(node) for index, node in state["nodes"]}


def _may_be_missed(event: CornerReached, corners: bool) -> bool:
    """Whether this corner need not be met every time. corners: whether it is corners that closed the loop."""
    if event.kind == BEND:
        return corners
    return event.kind == "concave" and abs(event.turn) < WEAK
