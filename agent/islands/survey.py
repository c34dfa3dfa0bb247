"""Mapping one boundary after another, and telling what an obstacle is that was followed all the way round."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...maps.boundary.layout import PLACE
from ..boundary.trace import BEND
from ..codec import decode, encode
from ..estimation.wheel_calibration import MismatchEstimate
from ..mapping.corners import Mapper, MappingConfig
from .candidate import ROUND, Candidate
from .links import is_same, take_back
from .outlines import Outline, outline_from

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...maps.local.local_map import LocalMap
    from ..agent import Agent
    from ..behavior import Context
    from ..events import CornerReached
    from ..goals import LocalSamples
    from ..mapping.base import ArcKey, MapSink
    from .anchor import Anchor


class Verdict(Enum):
    """What an obstacle is that was followed all the way round."""

    ISLAND = "an island, new on the map"
    OUTER = "the outer boundary"
    KNOWN = "an island known already"
    UNMAPPED = "nothing that can be mapped"


class Survey:
    """Maps the first boundary, then one candidate for an island after another, each with its own mapper.

    It is the sink of these mappers: it notes where an island's first node is, and hands on what they make.
    known: tells the outlines known so far. on_known: told the node when the last corners are known ones.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        sink: MapSink,
        config: MappingConfig,
        anchor: Anchor,
        known: Callable[[], list[Outline]],
        on_known: Callable[[int], None],
    ) -> None:
        """Begins with the first boundary."""
        self.agent, self.map, self.config = agent, hybrid_map, config
        self._sink, self._anchor, self._known, self._on_known = sink, anchor, known, on_known
        self.candidate: Candidate | None = None
        self.mapper = Mapper(agent, hybrid_map, self, config, self._take_corner)
        self.mismatch = self.mapper.meter.mismatch
        self._gone: tuple[list[int], list[ArcKey]] = ([], [])

    def begin(self) -> None:
        """Begins with an obstacle whose wall the robot follows."""
        self.mapper.close()
        self.candidate = Candidate()
        self.mapper = Mapper(self.agent, self.map, self, self.config, self._take_corner)
        self.mapper.meter.mismatch = self.mismatch

    def fails(self, context: Context) -> bool:
        """Takes a tick along the obstacle: whether it cannot be mapped, as it is round or never closes."""
        assert self.candidate is not None
        self.candidate.follow(context.pose, context.turn)
        bends = all(corner.kind == BEND for corner in self.mapper.loop.trace.corners)
        is_round = bends and abs(self.candidate.turned) > ROUND
        return is_round or (self.mapper.done and self.mapper.reason != "loop closed")

    def judge(self, closed: int) -> Verdict:
        """What the obstacle is, its loop being closed at node `closed`; all but an island is dropped."""
        candidate = self.candidate
        assert candidate is not None
        assert candidate.place is not None
        if closed != candidate.first:  # corners before that were none: a crossing had met an edge of it
            at = self.mapper.loop.trace.poses()[self.mapper.index(closed)]
            at = candidate.place.compose(at.x, at.y)
            self.map.annotate(closed, **{PLACE: [at.x, at.y]})
            self._take_back(node for node in self.mapper.nodes if node < closed)
            candidate.first = closed
        verdict = self._verdict(closed)
        if verdict is not Verdict.ISLAND:
            self.drop()
        return verdict

    def _verdict(self, closed: int) -> Verdict:
        known = [outline for outline in self._known() if closed not in outline.nodes]
        island = outline_from(self.map, closed)
        if island is None:
            return Verdict.UNMAPPED
        if island.turning == known[0].turning:
            return Verdict.OUTER
        same = any(is_same(outline, island) for outline in known[1:])
        return Verdict.KNOWN if same else Verdict.ISLAND

    def drop(self) -> None:
        """Takes back the nodes of what is no island, or cannot be mapped."""
        self.mapper.stop("not an island of its own")
        self._take_back(node for node in self.mapper.nodes if node in self.map.graph)

    def _take_back(self, taken: Iterable[int]) -> None:
        nodes, arcs = take_back(self.map, taken)
        self._gone[0].extend(nodes)
        self._gone[1].extend(arcs)

    @property
    def has_dropped(self) -> bool:
        """Whether nodes were taken back and the sink has not been told."""
        return bool(self._gone[0])

    def save(self) -> None:
        """Tells the sink what was taken back; the robot stands at a known node."""
        gone, self._gone = self._gone, ([], [])
        self._sink.rest(*gone)

    def _take_corner(self, event: CornerReached) -> bool:
        """Before the mapper takes a corner: the first of an island anchors it; known ones end its mapping."""
        self._anchor.meet(event)
        candidate = self.candidate
        if candidate is None:
            return False
        corner = self._anchor.at(event)
        if event.kind != BEND:
            node = candidate.known_as(self.map, self._known(), corner, event)
            if node is not None:
                self.drop()
                self._on_known(node)
                return True
        if not self.mapper.loop.trace.corners and candidate.place is None:
            candidate.place = corner
            self.mapper.heading = event.heading
        return False

    # --- sink of the mapper ------------------------------------------------------------------------------

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """As its own sink does."""
        return self._sink.build(samples, entry_heading)

    def commit(self, node: int, corner: CornerReached) -> None:
        """Notes where an island's first node is, and hands the node on."""
        candidate = self.candidate
        if candidate is not None and candidate.first is None and candidate.place is not None:
            candidate.first = node
            self.map.annotate(node, **{PLACE: [candidate.place.x, candidate.place.y]})
        self._sink.commit(node, corner)

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Never called: a boundary's mapper takes nothing back."""

    # --- state ---------------------------------------------------------------------------------------

    def state(self, mapping: bool) -> dict[str, Any]:
        """What a resumed mapping needs, as JSON. mapping: whether a boundary is being mapped now."""
        return {
            "mapper": self.mapper.state() if mapping else None,
            "mismatch": encode(self.mismatch),
            "heading": self.mapper.heading,
            "candidate": encode(self.candidate),
        }

    def restore(self, state: Mapping[str, Any], first: bool, mapping: bool) -> None:
        """Goes back to a `state`. first: whether the first boundary was not closed yet."""
        if not first:
            self.mapper.stop("the boundary is mapped")
            if mapping:
                self.begin()
            self.candidate = decode(state["candidate"], Candidate)
        if state["mapper"] is not None:
            self.mapper.restore(state["mapper"])
        self.mismatch = self.mapper.meter.mismatch = decode(state["mismatch"], MismatchEstimate)
        self.mismatch.apply(self.agent.odometry)
        self.mapper.heading = state["heading"]
