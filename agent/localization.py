"""Where on a mapped boundary the robot is, when it was not told: a Bayes filter over the map's corners.

The robot follows the wall by the side the map was made with. Every corner it meets, every length between two
of them and every turn speaks for some places of the map and against others. It claims a place only when that
one alone explains what was met; in a room that looks the same from several places it never does.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..world.robot import wrap_angle
from .boundary import BEND
from .events import BehaviorFinished, CornerReached, Localized, Lost, WallMet
from .goals import Follow
from .maneuvers import Foray

if TYPE_CHECKING:
    from ..maps.hybrid_map import HybridMap
    from ..world.robot import Percept
    from .agent import Agent
    from .behavior import Context

_ROUND = 2.6 * math.pi
"""Turned so far (rad) along one wall: right round an obstacle, and more than any room's corners turn back."""
_AWAY = 0.4 * math.pi
"""Radians to turn from a wall to leave it: not quite across, as the wall beyond a corner may be near."""


@dataclass(frozen=True, slots=True)
class LocalizationConfig:
    """What evidence weighs. Lengths in m, angles in rad, evidence in nats.

    length_deviation, length_slope: standard deviation of an arc's length, fixed and per meter.
    turn_deviation: of a corner's turn. floor: no single length or turn speaks more strongly against a place.
    other_kind: what a corner of the other kind speaks against it. margin: by how much the best place must
    lead. misfit: how much may speak against the best place for each arc, and twice that for any one of them.
    least_arcs: whole arcs to have seen. loops: after so many times round without a claim it is ambiguous.
    jump: no place falls farther behind the best, so that the filter finds back after a stretch of boundary
    that has changed. away: what speaks against a place at first that is not near where the robot is thought
    to be. forays: how often it leaves a wall that tells nothing for another.
    """

    length_deviation: float = 0.006
    length_slope: float = 0.006
    turn_deviation: float = 0.07
    floor: float = 8.0
    other_kind: float = 10.0
    margin: float = 14.0
    misfit: float = 3.5
    least_arcs: int = 2
    loops: float = 1.5
    jump: float = 24.0
    away: float = 20.0
    forays: int = 3


CHANGED = LocalizationConfig(least_arcs=3)
"""Where the world is known to have changed: a stretch that is new may look like another for two arcs."""


@dataclass(frozen=True, slots=True)
class _Loop:
    """A boundary: its lowest node, its length (m) and how it turns, 0.0 if it is not closed."""

    first: int
    length: float
    sense: float


class BoundaryFilter:
    """Evidence for each node of being the corner that the robot met last. Knows only what it is told."""

    def __init__(
        self,
        hybrid_map: HybridMap,
        config: LocalizationConfig = LocalizationConfig(),
        near: Collection[int] = (),
    ) -> None:
        """near: nodes of which one is likely to be met first; without them all are equally likely."""
        self.config = config
        side = hybrid_map.meta.side
        nodes = hybrid_map.graph.nodes
        # Bends are not met at the same place every time: only corners tell where one is.
        corners = [node for node in hybrid_map.nodes() if nodes[node]["corner"] != "none"]
        self._corner = {node: str(nodes[node]["corner"]) for node in corners}
        self._turn = {node: float(nodes[node]["turn"]) for node in nodes}
        self._onward: dict[int, tuple[int, float]] = {}
        for node in nodes:
            arc = hybrid_map.next_arc(node, side)
            if arc is not None:
                self._onward[node] = (arc.end, arc.distance)
        self._next = {node: found for node in corners if (found := self._next_corner(node)) is not None}
        self._into = dict(self._next.values())
        self._loop = {node: self._loop_of(node) for node in nodes}
        self.evidence: dict[int, float] = {}
        self._latest: dict[int, tuple[float, ...]] = {}
        self.restart()
        if near:
            self.evidence = {node: 0.0 if node in near else -config.away for node in corners}

    def restart(self) -> None:
        """All nodes are equally likely again: the robot has left the boundary that it followed."""
        self.evidence = dict.fromkeys(self._corner, 0.0)
        self._latest = dict.fromkeys(self._corner, ())
        self.arcs = 0
        self.length = 0.0

    @property
    def loop_length(self) -> float:
        """Length (m) of the longest boundary, along the arcs that lead on by the map's side."""
        return max((loop.length for loop in self._loop.values()), default=0.0)

    @property
    def boundary_length(self) -> float:
        """Length (m) of the longest boundary that the robot may be on."""
        return max((self._loop[node].length for node in self.rivals), default=self.loop_length)

    def senses(self) -> set[float]:
        """How the closed boundaries of the map turn: +1.0 counter-clockwise, -1.0 clockwise."""
        return {loop.sense for loop in self._loop.values() if loop.sense}

    @property
    def boundaries(self) -> int:
        """How many boundaries the map has."""
        return len(set(self._loop.values()))

    def _next_corner(self, node: int) -> tuple[int, float] | None:
        """The corner that follows a node, past bends, and how far (m) it is."""
        at, length = node, 0.0
        for _ in self._turn:
            if at not in self._onward:
                return None
            at, step = self._onward[at]
            length += step
            if at in self._corner:
                return at, length
        return None

    def _loop_of(self, node: int) -> _Loop:
        """The boundary on which `node` is, followed forward."""
        nodes, at, length = [node], node, 0.0
        while at in self._onward:
            at, step = self._onward[at]
            length += step
            if at in nodes:
                break
            nodes.append(at)
        closed = at == node and len(nodes) > 1
        turn = math.fsum(self._turn[each] for each in nodes) if closed else 0.0
        return _Loop(min(nodes), round(length, 6), math.copysign(1.0, turn) if turn else 0.0)

    def corner(self, kind: str, length: float) -> None:
        """Tells the next corner, `length` m after the one before, or after the wall was met."""
        first = self.length == 0.0
        self.length += max(length, 1e-9)
        if first:
            for node in self.evidence:
                into = self._into.get(node)
                if into is not None and length > into + 4.0 * self._deviation(into):
                    self._speak(node, -self.config.floor)
        else:
            self.arcs += 1
            self._move(length)
        for node in self.evidence:
            if self._corner[node] != kind:
                self._speak(node, -self.config.other_kind)

    def _move(self, length: float) -> None:
        """Takes every place on to the next node, `length` m being what was driven."""
        evidence = dict.fromkeys(self._corner, -math.inf)
        latest: dict[int, tuple[float, ...]] = dict.fromkeys(self._corner, ())
        for node, before in self.evidence.items():
            if node not in self._next:
                continue
            end, expected = self._next[node]
            z = (length - expected) / self._deviation(expected)
            says = -min(self.config.floor, 0.5 * z * z)
            evidence[end] = before + says
            latest[end] = (*self._latest[node], says)[-self.config.least_arcs :]
        least = max(evidence.values(), default=0.0) - self.config.jump
        for node in evidence:
            if evidence[node] < least:
                evidence[node], latest[node] = least, ()
        self.evidence, self._latest = evidence, latest

    def _speak(self, node: int, says: float) -> None:
        self.evidence[node] += says
        if self._latest[node]:
            *earlier, last = self._latest[node]
            self._latest[node] = (*earlier, last + says)

    def turned(self, turn: float) -> None:
        """Tells how the boundary turned at the last corner (rad, counter-clockwise)."""
        for node in self.evidence:
            z = wrap_angle(turn - self._turn[node]) / self.config.turn_deviation
            self._speak(node, -min(self.config.floor, 0.5 * z * z))

    @property
    def ranking(self) -> list[tuple[float, int]]:
        """(evidence, node), the likeliest first."""
        return sorted(
            ((evidence, node) for node, evidence in self.evidence.items()), key=lambda e: (-e[0], e[1])
        )

    @property
    def claim(self) -> int | None:
        """The node the robot is at, if what was met leaves no other; None if it is not sure."""
        ranking = self.ranking
        if not ranking or self.arcs < self.config.least_arcs:
            return None
        best, node = ranking[0]
        latest = self._latest[node]
        most = self.config.misfit
        if len(latest) < self.config.least_arcs or sum(latest) < -most * len(latest):
            return None
        if min(latest) < -2.0 * most:
            return None
        if len(ranking) > 1 and best - ranking[1][0] < self.config.margin:
            return None
        return node

    @property
    def rivals(self) -> list[int]:
        """The nodes that explain what was met about as well as the best."""
        ranking = self.ranking
        return [node for evidence, node in ranking if ranking[0][0] - evidence < self.config.margin]

    def _deviation(self, length: float) -> float:
        return self.config.length_deviation + self.config.length_slope * length


class Localizer:
    """Drives along the boundary until it knows where it is. `done` then; `node` is None if it never knew.

    reason: why it ended: "localized", "ambiguous: ..." or what went wrong. length: m of boundary followed.
    On an obstacle that is not on the map, or tells nothing, it leaves by a foray for another wall.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        config: LocalizationConfig = LocalizationConfig(),
        near: Collection[int] = (),
    ) -> None:
        """Subscribes to the agent's events; `begin` starts the drive. near: as for `BoundaryFilter`."""
        self.agent = agent
        self.side = hybrid_map.meta.side
        self.filter = BoundaryFilter(hybrid_map, config, near)
        self.done = False
        self.node: int | None = None
        self.reason = ""
        self._before = 0.0
        self._forays = 0
        self._turned = self._bent = 0.0
        self._leaving = False
        self._corner: CornerReached | None = None
        self._subscriptions = [
            agent.bus.subscribe(CornerReached, self._on_corner),
            agent.bus.subscribe(WallMet, self._on_wall),
            agent.bus.subscribe(BehaviorFinished, self._on_finished),
        ]

    @property
    def length(self) -> float:
        """Meters of boundary followed, all in all."""
        return self._before + self.filter.length

    def begin(self) -> None:
        """Looks for a wall and follows it."""
        self.agent.processes.append(self)
        self._follow()

    def _follow(self) -> None:
        self._turned, self._bent, self._corner, self._leaving = 0.0, 0.0, None, False
        self.agent.start("wall-following", Follow(self.side))

    def cancel(self) -> None:
        """Stops where the robot is, without having found out."""
        if not self.done:
            self._close("cancelled")

    def update(self, percept: Percept, context: Context) -> None:
        """Watches for a boundary that is none of the map's: it turns the other way, or has no corners."""
        if self.done or self._leaving:
            return
        self._turned += context.turn
        if abs(self._turned) < _ROUND:
            return
        strange = math.copysign(1.0, self._turned) not in self.filter.senses()
        if strange or self.filter.length == 0.0:
            self._leave("an obstacle that is not on the map")

    def _on_wall(self, event: WallMet) -> None:
        if self._corner is not None and not self.done and not self._leaving:
            self.filter.turned(wrap_angle(event.heading - self._corner.heading))
            self._corner = None

    def _on_corner(self, event: CornerReached) -> None:
        if self.done or self._leaving:
            return
        if event.kind == BEND:
            self._bent += event.path_length
            return
        self._corner = event
        length, self._bent = self._bent + event.path_length, 0.0
        self.filter.corner(event.kind, length)
        claim = self.filter.claim
        if claim is not None:
            self.node = claim
            self.agent.bus.publish(Localized(time=event.time, node=claim))
            self._end("localized")
        elif self.filter.length > self.filter.config.loops * self.filter.boundary_length:
            rivals = ", ".join(map(str, self.filter.rivals))
            reason = f"ambiguous: cannot tell nodes {rivals} apart"
            if self.filter.boundaries > 1:
                self._leave(reason)
            else:
                self._end(reason)

    def _leave(self, reason: str) -> None:
        """Straight away from the wall it follows, to another one; a few times, then it gives up."""
        if self._forays >= self.filter.config.forays:
            self._end(reason)
            return
        self._forays += 1
        self._leaving = True
        self._before += self.filter.length
        self.filter.restart()
        self.agent.stop("wall-following")
        away = _AWAY if self.side == "right" else -_AWAY
        self.agent.start("foray", Foray(away, self.filter.loop_length))

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior == "foray" and self._leaving and not self.done:
            self._follow()

    def _end(self, reason: str) -> None:
        self._close(reason)
        if self.node is None:
            self.agent.bus.publish(Lost(time=self.agent.context.time, reason=reason))

    def _close(self, reason: str) -> None:
        self.done, self.reason = True, reason
        self.agent.stop("wall-following")
        for subscription in self._subscriptions:
            subscription.cancel()
        if self in self.agent.processes:
            self.agent.processes.remove(self)
