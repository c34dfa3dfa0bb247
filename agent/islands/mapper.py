"""Mapping of all walls of a room: first the boundary the robot stands at, then islands, found by crossings.

    map the boundary -> drive a line across what it encloses -> a known wall? then the next line
                                                             -> another? an island: map it, link it ...

The outer boundary, once closed, is a polygon in the map frame. Parallel lines over its inside are driven one
after the other, each from a place that is reached by the arcs of the map. Path integration starts afresh
from the wall that a line leaves, so that its end is known well enough to tell a known wall from a new one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import Percept
from ..codec import decode, encode, reinstate, snapshot
from ..events import CornerReached, Localized, LoopClosed, Lost, NodePassed, NodeReached
from ..goals import START_AT, Follow
from ..listener import Listener, Outcome
from ..localization.localizer import Localizer
from ..mapping.base import MapSink
from ..mapping.corners import Mapper, MappingConfig
from ..navigation.corners import Navigator
from ..navigation.crossing import CrossingDrive, Stage
from ..walls import away_from
from .anchor import Anchor
from .candidate import ROUND
from .coverage import ScoutConfig, Scouting
from .links import is_same, leads, link_islands, unproven_link
from .outlines import Outline
from .survey import Survey, Verdict
from .sweep import Sweep

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent
    from ..behavior import Context
    from .sweep import Chord

_FARTHEST = 5.0
"""Meters across open space until a crossing is given up."""
_LEAVES = 5
"""How often it sets out from an island without knowing where that leads."""
_BEHAVIORS = ("wall-following", "local-exploration", "position-correction", "go-to-node", "foray")
_KEPT = ("_doing", "_node", "forays", "islands", "_leaves")


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
    """Maps a boundary and then the islands within, each by a `Mapper`.

    The sink's `rest` is called while the robot stands at a known node, so that all can be saved. forays:
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
        self.agent, self.map, self.config = agent, hybrid_map, scouting
        self.side = config.side
        self.scouted = ""
        self.forays = 0
        self.islands = 0
        self._doing = Doing.BOUNDARY
        self._anchor = Anchor(agent.odometry, self.side, scouting.near, scouting.near_slope)
        self._survey = Survey(agent, hybrid_map, sink, config, self._anchor, self._known, self._on_recognized)
        self._navigator: Navigator | None = None
        self._drive = CrossingDrive(agent, self.side, self._on_crossed, self._on_landed)
        self._scouting = Scouting(Sweep(0.0, ()), scouting)  # nothing is enclosed yet
        self._node = -1
        self._chord: Chord | None = None
        self._turned = 0.0
        self._finding = False
        self._leaves = 0
        self.listen(CornerReached, self._anchor.meet)
        self.listen(LoopClosed, self._on_closed)
        self.listen(NodePassed, self._on_passed)
        self.listen(NodeReached, self._on_reached)
        self.listen(Localized, self._on_localized)
        self.listen(Lost, self._on_lost)

    # --- what a run needs -----------------------------------------------------------------------------

    @property
    def mapper(self) -> Mapper:
        """What maps the boundary at hand, or mapped the last."""
        return self._survey.mapper

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
        return {
            **snapshot(self, _KEPT),
            "scouting": encode(self._scouting),
            "survey": self._survey.state(self._doing in (Doing.BOUNDARY, Doing.ISLAND)),
            "anchor": self._anchor.state(),
            "heard": self.agent.bus.corners,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        reinstate(self, _KEPT, state, Doing)
        self._survey.restore(state["survey"], self._doing is Doing.BOUNDARY, self._doing is Doing.ISLAND)
        scouting = decode(state["scouting"], Scouting, ScoutConfig, Sweep, Outline)
        self._scouting = replace(scouting, config=self.config)
        self._anchor.restore(state["anchor"])
        self.agent.bus.corners = int(state["heard"])

    def update(self, percept: Percept, context: Context) -> None:
        """Watches for what has no event: a mapping given up, an island without corners."""
        if self._doing is Doing.BOUNDARY and self.mapper.done and self.mapper.reason != "loop closed":
            self._end(self.mapper.reason, "the boundary was not closed")
        if self._doing is Doing.CROSSING and self._drive.stage is Stage.JOIN:
            self._turned += context.turn
            if abs(self._turned) > ROUND:
                self._leave_round_wall()
        if self._doing is Doing.ISLAND and self._survey.fails(context):
            self._survey.drop()
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
        self._survey.save()
        self._choose()

    def _choose(self) -> None:
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
        elif self._doing is Doing.GOING and self._chord is not None:
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
        hit = self.agent.odometry.pose
        self._turned = 0.0
        if self._chord is not None:
            self._scouting.drove(self._chord, hit.x, hit.y)
        if not self._scouting.is_known(self._known(), hit.x, hit.y, distance):
            self._drive.release()
            self._begin_island()

    def _on_passed(self, event: NodePassed) -> None:
        if self._doing is not Doing.BOUNDARY:
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
        self._survey.begin()

    def _on_recognized(self, node: int) -> None:
        """What was taken for an island is known: the robot stands at a node of it."""
        self._finding = False
        self._stop()
        self._rest(node)

    def _take_island(self, closed: int) -> None:
        """Its loop is closed at node `closed`: is it new?"""
        here = self.mapper.current
        verdict = self._survey.judge(closed)
        if verdict is Verdict.ISLAND:
            self.islands += 1
            self._rest(here)
        elif verdict is Verdict.OUTER:
            self._localize()
        elif verdict is Verdict.KNOWN:
            self._find_wall()
        else:
            self._give_up_island()

    def _give_up_island(self) -> None:
        """It cannot be mapped: remembered as something in the way; away from it, straight."""
        assert self._survey.candidate is not None
        self._finding = False
        blind = self._survey.candidate.outline
        if not any(is_same(outline, blind) for outline in self._known()[1:]):
            self._scouting.blind.append(blind)
        self._stop()
        self._leave()

    # --- lost and done --------------------------------------------------------------------------------

    def _find_wall(self) -> None:
        """Something went wrong, but path integration still knows about where: the next corner will tell."""
        self._doing, self._chord = Doing.CROSSING, None
        self._finding = True
        self._turned = 0.0
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
        if self._survey.has_dropped:
            self._survey.save()
        self.scouted, self._doing = scouted, Doing.DONE
        self._stop()
        self.finish(reason == "loop closed", self._node, reason)

    def _stop(self) -> None:
        for name in _BEHAVIORS:
            self.agent.stop(name)
