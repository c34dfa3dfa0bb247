"""Mapping of all walls of a room: first the boundary the robot stands at, then islands, found by crossings.

    map the boundary -> drive a line across what it encloses -> a known wall? then the next line
                                                             -> another? an island: map it, link it ...

The outer boundary, once closed, is a polygon in the map frame. Parallel lines over its inside are driven one
after the other, each from a place that is reached by the arcs of the map. Path integration starts afresh
from the wall that a line leaves, so that its end is known well enough to tell a known wall from a new one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...maps.boundary.layout import PLACE
from ...world.robot import Percept
from ..boundary.trace import BEND
from ..events import CornerReached, Localized, LoopClosed, Lost, NodePassed, NodeReached
from ..goals import START_AT, Follow
from ..listener import Listener, Outcome
from ..localization.localizer import Localizer
from ..mapping.base import ArcKey, MapSink
from ..mapping.corners import Mapper, MappingConfig
from ..navigation.corners import Navigator
from ..navigation.crossing import CrossingDrive, Stage
from ..walls import away_from
from .anchor import Anchor
from .candidate import ROUND, Candidate
from .coverage import ScoutConfig, Scouting
from .links import is_same, leads, link_islands, take_back, unproven_link
from .outlines import Outline, outline_from

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...maps.local.local_map import LocalMap
    from ..agent import Agent
    from ..behavior import Context
    from ..goals import LocalSamples
    from .sweep import Chord

_FARTHEST = 5.0
"""Meters across open space until a crossing is given up."""
_LEAVES = 5
"""How often it sets out from an island without knowing where that leads."""
_BEHAVIORS = ("wall-following", "local-exploration", "position-correction", "go-to-node", "foray")


class Doing(Enum):
    """What it is about."""

    BOUNDARY = "mapping the boundary"
    GOING = "driving to where a crossing sets out"
    CROSSING = "crossing open space"
    ISLAND = "mapping an island"
    PROVING = "driving a link again"
    LOST = "finding out where it is"
    DONE = "done"


class IslandMapper(Listener):
    """Maps a boundary and then the islands within, with a `Mapper` for each, whose sink it is.

    Its own sink's `rest` is called while the robot stands at a known node, so that all can be saved. forays:
    how many crossings were driven. islands: how many it found. scouted: why the search for them ended.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        sink: MapSink,
        config: MappingConfig = MappingConfig(),  # noqa: B008  frozen
        scouting: ScoutConfig = ScoutConfig(),  # noqa: B008  frozen
    ) -> None:
        """Listens to the agent's events; `start` starts the drive."""
        super().__init__(agent)
        self.agent, self.map, self.sink, self.config = agent, hybrid_map, sink, scouting
        self.side = config.side
        self.scouted = ""
        self.forays = 0
        self.islands = 0
        self._mapping = config
        self._doing = Doing.BOUNDARY
        self.mapper = Mapper(agent, hybrid_map, self, config, self._take_corner)
        self._mismatch = self.mapper.mismatch
        self._navigator: Navigator | None = None
        self._drive = CrossingDrive(agent, self.side, self._on_crossed, self._on_landed)
        self._scouting: Scouting | None = None
        self._node = -1
        self._chord: Chord | None = None
        self._candidate = Candidate()
        self._anchor = Anchor(agent.odometry, self.side, scouting.near, scouting.near_slope)
        self._finding = False
        self._leaves = 0
        self._gone: tuple[list[int], list[ArcKey]] = ([], [])
        self.listen(CornerReached, self._anchor.meet)
        self.listen(LoopClosed, self._on_closed)
        self.listen(NodePassed, self._on_passed)
        self.listen(NodeReached, self._on_reached)
        self.listen(Localized, self._on_localized)
        self.listen(Lost, self._on_lost)

    # --- what a run needs -----------------------------------------------------------------------------

    @property
    def current(self) -> int:
        """The node the robot is at, or met last; -1 if it does not know."""
        return self.mapper.current if self._doing in (Doing.BOUNDARY, Doing.ISLAND) else self._node

    def start(self) -> None:
        """Starts with the wall nearest ahead, or goes on after `restore`."""
        super().start()
        if self._doing in (Doing.BOUNDARY, Doing.ISLAND):
            self.mapper.start()
        elif self._node < 0:
            self._end("loop closed", "lost on a foray")
        else:
            self._choose()

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it where it is."""
        if not self.done:
            self.mapper.stop(reason)
            self._drive.release()
            self._end(reason, "stopped")

    def close(self) -> None:
        """Hears no more, nor do those that it owns."""
        super().close()
        self.mapper.close()
        self._drive.close()
        if self._navigator is not None:
            self._navigator.close()

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs, as JSON; to be taken when the sink is called."""
        mapping = self._doing in (Doing.BOUNDARY, Doing.ISLAND)
        return {
            "doing": self._doing.name,
            "mapper": self.mapper.state() if mapping else None,
            "mismatch": [self._mismatch.value, self._mismatch.variance],
            "scouting": None if self._scouting is None else self._scouting.state(),
            "node": self._node,
            "counts": [self.forays, self.islands, self._leaves],
            "heading": self.mapper.heading,
            **self._candidate.state(),
            **self._anchor.state(),
            "heard": self.agent.bus.corners,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        self._doing = Doing[state["doing"]]
        if self._doing is not Doing.BOUNDARY:
            self.mapper.stop("the boundary is mapped")
        if self._doing is Doing.ISLAND:
            self._new_mapper()
        if state["mapper"] is not None:
            self.mapper.restore(state["mapper"])
        self._mismatch.value, self._mismatch.variance = state["mismatch"]
        self._mismatch.apply(self.agent.odometry)
        self.mapper.heading = state["heading"]
        if state["scouting"] is not None:
            self._scouting = Scouting.restored(state["scouting"], self.config)
        self._node = int(state["node"])
        self.forays, self.islands, self._leaves = state["counts"]
        self._candidate = Candidate.restored(state)
        self._anchor.restore(state)
        self.agent.bus.corners = int(state.get("heard", 0))

    def update(self, percept: Percept, context: Context) -> None:
        """Watches for what has no event: a mapping given up, an island without corners."""
        if self._doing is Doing.BOUNDARY and self.mapper.done and self.mapper.reason != "loop closed":
            self._end(self.mapper.reason, "the boundary was not closed")
        candidate = self._candidate
        if self._doing is Doing.CROSSING and self._drive.stage is Stage.JOIN:
            candidate.turned += context.turn
            if abs(candidate.turned) > ROUND:
                self._leave_round_wall()
        if self._doing is not Doing.ISLAND:
            return
        candidate.follow(context.pose, context.turn)
        bends = all(corner.kind == BEND for corner in self.mapper.trace.corners)
        is_round = bends and abs(candidate.turned) > ROUND
        if is_round or (self.mapper.done and self.mapper.reason != "loop closed"):
            self._give_up_island()

    # --- choosing -------------------------------------------------------------------------------------

    def _on_closed(self, event: LoopClosed) -> None:
        if self._doing is Doing.BOUNDARY:
            self._scouting = Scouting.over(self.map, self.config)
            self._rest(self.mapper.current)
        elif self._doing is Doing.ISLAND:
            self._take_island(event.node)

    def _rest(self, node: int) -> None:
        """Stands at a known node: all can be saved; then on to the next crossing."""
        self._node, self._doing = node, Doing.GOING
        self._anchor.fix(self._known(), node)
        link_islands(self.map, self._known(), self.side)
        self._save()
        self._choose()

    def _save(self) -> None:
        gone, self._gone = self._gone, ([], [])
        self.sink.rest(*gone)

    def _choose(self) -> None:
        assert self._scouting is not None
        self._chord = self._scouting.next(self.map, self._node)
        if self._chord is not None:
            self._doing = Doing.GOING
            self._scouting.try_once(self._chord)
            self._go_to(self._known()[self._chord.start.outline].nodes[self._chord.start.edge])
            return
        if self._is_marooned() and self._leaves < _LEAVES:
            self._leaves += 1
            self._leave()
            return
        link = unproven_link(self.map, self._node)
        if link is not None:
            self._doing = Doing.PROVING
            self._navigator_at(self._node).drive([*self.map.path(self._node, link.start), link])
            return
        self._end("loop closed", "all is covered")

    def _is_marooned(self) -> bool:
        """Whether it is on an island and no crossing that is known leads away from it."""
        outer = self._known()[0].nodes
        return self._node not in outer and not leads(self.map, self._node, outer[0])

    def _leave_round_wall(self) -> None:
        """The wall it joined is that of a round obstacle known already: no corner will come."""
        self._drive.stop()
        self._finding = False
        self._leaves += 1
        if self._leaves > _LEAVES:
            self._end("loop closed", "no way off a round obstacle")
        else:
            self._leave()

    def _leave(self) -> None:
        """Straight away from the wall at its side, wherever that leads."""
        self._doing, self._chord = Doing.CROSSING, None
        self._drive.cross(0.4 * math.pi * away_from(self.side), _FARTHEST)

    def _known(self) -> list[Outline]:
        assert self._scouting is not None
        return self._scouting.all(self.map)

    def _navigator_at(self, node: int) -> Navigator:
        if self._navigator is None:
            self._navigator = Navigator(self.agent, self.map, node, self.side, learn_mismatch=False)
        self._navigator.stand_at(node, self.side)
        return self._navigator

    def _go_to(self, node: int) -> None:
        self._navigator_at(self._node).go(node)

    # --- crossings ------------------------------------------------------------------------------------

    def _on_reached(self, event: NodeReached) -> None:
        if self._doing is Doing.PROVING:
            self._learn_crossings()
            self._rest(event.node)
        elif self._doing is Doing.GOING and self._chord is not None and self._scouting is not None:
            self._learn_crossings()
            self._doing = Doing.CROSSING
            self.forays += 1
            data = self.map.graph.nodes[event.node]
            start = START_AT[data["corner"]]
            crossing, pose = self._scouting.crossing(self._known(), self._chord)
            self._drive.begin(crossing, start, data["turn"] or None, pose=pose, most=_FARTHEST)

    def _learn_crossings(self) -> None:
        assert self._navigator is not None
        for leg in self._navigator.legs:
            if leg.foray:
                self.map.record_traversal(leg.source, leg.target, "foray", leg.distance, both_ways=False)

    def _on_landed(self, distance: float) -> None:
        """A wall is met, and being joined: known, or an island."""
        assert self._scouting is not None
        hit = self.agent.odometry.pose
        self._candidate.turned = 0.0
        if self._chord is not None:
            self._scouting.drove(self._chord, hit.x, hit.y)
        if not self._scouting.is_known(self._known(), hit.x, hit.y, distance):
            self._drive.release()
            self._begin_island()

    def _on_passed(self, event: NodePassed) -> None:
        if self._scouting is not None:
            self._anchor.fix(self._known(), event.node)

    def _on_crossed(self, outcome: Outcome) -> None:
        """At the corner after a wall that should be known, or the crossing failed."""
        if not outcome.succeeded:
            self._find_wall()
            return
        _, corner = outcome.result
        self._anchor.meet(corner)
        node = self._anchor.node_at(self._known(), corner)
        if node is not None:
            self._finding = False
            self._rest(node)
            return
        if self._finding:
            self._localize()
            return
        self._begin_island()
        self.agent.start("wall-following", Follow(self.side, START_AT[corner.kind], corner.turn))

    # --- islands --------------------------------------------------------------------------------------

    def _begin_island(self) -> None:
        self._doing = Doing.ISLAND
        self._new_mapper()
        self._candidate = Candidate()

    def _new_mapper(self) -> None:
        self.mapper.close()
        self.mapper = Mapper(self.agent, self.map, self, self._mapping, self._take_corner)
        self.mapper.meter.mismatch = self._mismatch

    def _take_corner(self, event: CornerReached) -> bool:
        """Before the mapper takes a corner: the first of an island anchors it; known ones end its mapping."""
        self._anchor.meet(event)
        if self._doing is not Doing.ISLAND:
            return False
        corner, candidate = self._anchor.at(event), self._candidate
        if event.kind != BEND:
            node = candidate.known_as(self.map, self._known(), corner, event)
            if node is not None:
                self._drop_island()
                self._stop()
                self._rest(node)
                return True
        if not self.mapper.trace.corners and candidate.place is None:
            candidate.place = corner
            self.mapper.heading = event.heading
        return False

    # --- sink of the mapper ------------------------------------------------------------------------------

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """As its own sink does."""
        return self.sink.build(samples, entry_heading)

    def commit(self, node: int, corner: CornerReached) -> None:
        """Notes where an island's first node is, and hands the node on."""
        candidate = self._candidate
        if self._doing is Doing.ISLAND and candidate.first is None and candidate.place is not None:
            candidate.first = node
            self.map.annotate(node, **{PLACE: [candidate.place.x, candidate.place.y]})
        self.sink.commit(node, corner)

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Never called: a boundary's mapper takes nothing back."""

    def _take_island(self, closed: int) -> None:
        """Its loop is closed at node `closed`: is it new?"""
        here, place = self.mapper.current, self._candidate.place
        assert place is not None
        if closed != self._candidate.first:  # corners before that were none: a crossing had met an edge of it
            at = self.mapper.trace.poses()[self.mapper.index(closed)]
            at = place.compose(at.x, at.y)
            self.map.annotate(closed, **{PLACE: [at.x, at.y]})
            self._drop(node for node in self.mapper.nodes if node < closed)
            self._candidate.first = closed
        known = [outline for outline in self._known() if closed not in outline.nodes]
        island = outline_from(self.map, closed)
        if island is None:
            self._give_up_island()
        elif island.turning == known[0].turning:
            self._drop_island()
            self._localize()
        elif any(is_same(outline, island) for outline in known[1:]):
            self._drop_island()
            self._find_wall()
        else:
            self.islands += 1
            self._candidate.first = None
            self._rest(here)

    def _drop_island(self) -> None:
        """Takes back the nodes of what is no island, or cannot be mapped."""
        self._finding = False
        self.mapper.stop("not an island of its own")
        self._drop(node for node in self.mapper.nodes if node in self.map.graph)
        self._candidate.first = None

    def _drop(self, taken: Iterable[int]) -> None:
        nodes, arcs = take_back(self.map, taken)
        self._gone[0].extend(nodes)
        self._gone[1].extend(arcs)

    def _give_up_island(self) -> None:
        """It cannot be mapped: remembered as something in the way; away from it, straight."""
        assert self._scouting is not None
        self._drop_island()
        blind = self._candidate.outline
        if not any(is_same(outline, blind) for outline in self._known()[1:]):
            self._scouting.blind.append(blind)
        self._stop()
        self._leave()

    # --- lost and done --------------------------------------------------------------------------------

    def _find_wall(self) -> None:
        """Something went wrong, but path integration still knows about where: the next corner will tell."""
        self._doing, self._chord = Doing.CROSSING, None
        self._finding = True
        self._candidate.turned = 0.0
        self._drive.stop()
        self._drive.join()

    def _localize(self) -> None:
        self._doing, self._finding = Doing.LOST, False
        self._drive.stop()
        self._localizer = Localizer(self.agent, self.map)
        self._localizer.start()

    def _on_localized(self, event: Localized) -> None:
        if self._doing is Doing.LOST:
            self._rest(event.node)

    def _on_lost(self, event: Lost) -> None:
        if self._doing is Doing.LOST:
            self._node = -1
            self._end("loop closed", f"lost on a foray: {event.reason}")
        elif self._doing in (Doing.GOING, Doing.PROVING):
            failed = self._navigator.failed if self._navigator is not None else None
            if failed is not None and failed.kind == "foray":
                self.map.block(failed.source, failed.target, "foray")
            self._find_wall()

    def _end(self, reason: str, scouted: str) -> None:
        if self._gone[0]:
            self._save()
        self.scouted, self._doing = scouted, Doing.DONE
        self._stop()
        self.finish(reason == "loop closed", self._node, reason)

    def _stop(self) -> None:
        for name in _BEHAVIORS:
            self.agent.stop(name)
