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
from .events import CornerReached, Localized, Lost, WallMet
from .goals import Follow

if TYPE_CHECKING:
    from ..maps.hybrid_map import HybridMap
    from .agent import Agent


@dataclass(frozen=True, slots=True)
class LocalizationConfig:
    """What evidence weighs. Lengths in m, angles in rad, evidence in nats.

    length_deviation, length_slope: standard deviation of an arc's length, fixed and per meter.
    turn_deviation: of a corner's turn. floor: no single length or turn speaks more strongly against a place.
    other_kind: what a corner of the other kind speaks against it. margin: by how much the best place must
    lead. misfit: how much may speak against the best place for each arc. least_arcs: whole arcs to have
    seen. loops: after so many times round without a claim it is ambiguous. jump: no place falls farther
    behind the best, so that the filter finds back after a stretch of boundary that has changed. away: what
    speaks against a place at first that is not near where the robot is thought to be.
    """

    length_deviation: float = 0.006
    length_slope: float = 0.006
    turn_deviation: float = 0.07
    floor: float = 8.0
    other_kind: float = 10.0
    margin: float = 14.0
    misfit: float = 5.0
    least_arcs: int = 2
    loops: float = 1.5
    jump: float = 24.0
    away: float = 20.0


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
        self._corner = {node: str(nodes[node]["corner"]) for node in nodes}
        self._turn = {node: float(nodes[node]["turn"]) for node in nodes}
        self._next: dict[int, tuple[int, float]] = {}
        for node in nodes:
            arc = hybrid_map.next_arc(node, side)
            if arc is not None:
                self._next[node] = (arc.end, arc.distance)
        self._into = dict(self._next.values())
        far = -config.away if near else 0.0
        self.evidence: dict[int, float] = {node: 0.0 if node in near else far for node in nodes}
        self._latest: dict[int, tuple[float, ...]] = dict.fromkeys(nodes, ())
        self.arcs = 0
        self.length = 0.0

    @property
    def loop_length(self) -> float:
        """Length (m) of all arcs that lead on by the map's side."""
        return sum(length for _, length in self._next.values())

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
        least = max(evidence.values()) - self.config.jump
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
        if len(latest) < self.config.least_arcs or sum(latest) < -self.config.misfit * len(latest):
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

    `reason` says why it ended: "localized", "ambiguous: ..." or what went wrong.
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
        self._corner: CornerReached | None = None
        self._subscriptions = [
            agent.bus.subscribe(CornerReached, self._on_corner),
            agent.bus.subscribe(WallMet, self._on_wall),
        ]

    def begin(self) -> None:
        """Looks for a wall and follows it."""
        self.agent.start("wall-following", Follow(self.side))

    def cancel(self) -> None:
        """Stops where the robot is, without having found out."""
        if not self.done:
            self._close("cancelled")

    def _on_wall(self, event: WallMet) -> None:
        if self._corner is not None and not self.done:
            self.filter.turned(wrap_angle(event.heading - self._corner.heading))
            self._corner = None

    def _on_corner(self, event: CornerReached) -> None:
        if self.done:
            return
        self._corner = event
        self.filter.corner(event.kind, event.path_length)
        claim = self.filter.claim
        if claim is not None:
            self.node = claim
            self.agent.bus.publish(Localized(time=event.time, node=claim))
            self._end("localized")
        elif self.filter.length > self.filter.config.loops * self.filter.loop_length:
            rivals = ", ".join(map(str, self.filter.rivals))
            self._end(f"ambiguous: cannot tell nodes {rivals} apart")

    def _end(self, reason: str) -> None:
        self._close(reason)
        if self.node is None:
            self.agent.bus.publish(Lost(time=self.agent.context.time, reason=reason))

    def _close(self, reason: str) -> None:
        self.done, self.reason = True, reason
        self.agent.stop("wall-following")
        for subscription in self._subscriptions:
            subscription.cancel()
