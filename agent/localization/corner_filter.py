"""A Bayes filter over the corners of a mapped boundary: which of them the robot met last."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from ...maps.boundary.walk import onward, walk
from ...world.robot import wrap_angle

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap


@dataclass(frozen=True, slots=True)
class LocalizationConfig:
    """How measurements weigh. Lengths in m, angles in rad, log-likelihoods in nats.

    length_deviation, length_slope: standard deviation of an arc's length, fixed and per meter.
    turn_deviation: of a corner's turn. floor: no single length or turn costs a node more. other_kind: what a
    corner of the other kind costs it. margin: by how much the best node must lead. misfit: the most that the
    best node may have lost for each arc on average, and twice that for any one of them. least_arcs: whole
    arcs to have seen. loops: after so many times round without an estimate it is ambiguous. jump: no node
    falls farther behind the best, so that the filter finds back after a stretch of boundary that has changed.
    away: what a node costs at first that is not near where the robot is thought to be. forays: how often the
    robot crosses to another wall from one that tells nothing.
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


_ALIKE = 3.0
"""Deviations of one measurement up to which two arcs, or two turns, of a map are alike."""
_MOST = 40
"""Nodes of which it is asked whether any two are alike."""
_MOST_SEEN = 400
"""Nodes that a look around is compared with."""


class BoundaryFilter:
    """Log-likelihood of each node to be the corner that the robot met last. Knows only what it is told."""

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
        self._onward = onward(hybrid_map, side)
        self._next = {node: found for node in corners if (found := self._next_corner(node)) is not None}
        self._into = dict(self._next.values())
        self._loop = {node: self._loop_of(node) for node in nodes}
        self.log_likelihood: dict[int, float] = {}
        self._latest: dict[int, tuple[float, ...]] = {}
        self.restart()
        if near:
            self.log_likelihood = {node: 0.0 if node in near else -config.away for node in corners}

    def restart(self) -> None:
        """All nodes are equally likely again: the robot has left the boundary that it followed."""
        self.log_likelihood = dict.fromkeys(self._corner, 0.0)
        self._latest = dict.fromkeys(self._corner, ())
        self.arcs = self.looks = 0
        self.length = 0.0

    @property
    def loop_length(self) -> float:
        """Length (m) of the longest boundary, along the arcs that lead on by the map's side."""
        return max((loop.length for loop in self._loop.values()), default=0.0)

    @property
    def boundary_length(self) -> float:
        """Length (m) of the longest boundary that the robot may be on."""
        return max((self._loop[node].length for node in self.hypotheses), default=self.loop_length)

    def senses(self) -> set[float]:
        """How the closed boundaries of the map turn: +1.0 counter-clockwise, -1.0 clockwise."""
        return {loop.sense for loop in self._loop.values() if loop.sense}

    @property
    def boundaries(self) -> int:
        """How many boundaries the map has."""
        return len(set(self._loop.values()))

    def _next_corner(self, node: int) -> tuple[int, float] | None:
        """The corner that follows a node, past bends, and how far (m) it is."""
        way = walk(self._onward, node, self._corner)
        return (way.end, way.length) if way.end in self._corner else None

    def _loop_of(self, node: int) -> _Loop:
        """The boundary on which `node` is, followed forward."""
        way = walk(self._onward, node)
        closed = way.closed and len(way.nodes) > 1
        turn = math.fsum(self._turn[each] for each in way.nodes) if closed else 0.0
        return _Loop(min(way.nodes), round(way.length, 6), math.copysign(1.0, turn) if turn else 0.0)

    def corner(self, kind: str, length: float) -> None:
        """Tells the next corner, `length` m after the one before, or after the wall was met."""
        first = self.length == 0.0
        self.length += max(length, 1e-9)
        if first:
            for node in self.log_likelihood:
                into = self._into.get(node)
                if into is not None and length > into + 4.0 * self._deviation(into):
                    self._add(node, -self.config.floor)
        else:
            self.arcs += 1
            self._move(length)
        for node in self.log_likelihood:
            if self._corner[node] != kind:
                self._add(node, -self.config.other_kind)

    def _move(self, length: float) -> None:
        """Takes every place on to the next node, `length` m being what was driven."""
        scores = dict.fromkeys(self._corner, -math.inf)
        latest: dict[int, tuple[float, ...]] = dict.fromkeys(self._corner, ())
        for node, before in self.log_likelihood.items():
            if node not in self._next:
                continue
            end, expected = self._next[node]
            z = (length - expected) / self._deviation(expected)
            change = -min(self.config.floor, 0.5 * z * z)
            scores[end] = before + change
            latest[end] = (*self._latest[node], change)[-self.config.least_arcs :]
        least = max(scores.values(), default=0.0) - self.config.jump
        for node in scores:
            if scores[node] < least:
                scores[node], latest[node] = least, ()
        self.log_likelihood, self._latest = scores, latest

    def _add(self, node: int, change: float) -> None:
        self.log_likelihood[node] += change
        if self._latest[node]:
            *earlier, last = self._latest[node]
            self._latest[node] = (*earlier, last + change)

    def turned(self, turn: float) -> None:
        """Tells how the boundary turned at the last corner (rad, counter-clockwise)."""
        for node in self.log_likelihood:
            z = wrap_angle(turn - self._turn[node]) / self.config.turn_deviation
            self._add(node, -min(self.config.floor, 0.5 * z * z))

    def seen(self, change: Mapping[int, float]) -> None:
        """Takes what a look around at the last corner costs nodes (nats, 0 or less); empty if nothing."""
        self.looks += bool(change)
        for node, value in change.items():
            self.log_likelihood[node] += max(-self.config.floor, value)

    @property
    def contested(self) -> list[tuple[int, int]]:
        """Pairs of likely nodes that driving on will not tell apart, or has not for long; some, if many.

        That is known at the first corner if the boundary repeats itself: nodes of which all that follows is
        alike are told apart by views or never.
        """
        hypotheses = self.hypotheses
        if len(hypotheses) < 2 or self.estimate is not None:
            return []
        if self._proofs >= self.config.least_arcs:
            return list(combinations(hypotheses[:_MOST], 2))
        if len(hypotheses) > _MOST:
            return []
        return [pair for pair in combinations(hypotheses, 2) if self._twins(*pair)]

    def _twins(self, one: int, other: int) -> bool:
        """Whether the boundary from one node on is as that from the other, all the way round."""
        at = (one, other)
        for _ in self._corner:
            a, b = at
            turn = abs(wrap_angle(self._turn[a] - self._turn[b]))
            if self._corner[a] != self._corner[b] or turn > _ALIKE * self.config.turn_deviation:
                return False
            if a not in self._next or b not in self._next:
                return False
            (a, length), (b, second) = self._next[a], self._next[b]
            if abs(length - second) > _ALIKE * self._deviation(length):
                return False
            at = (a, b)
            if at == (one, other):
                return True
        return False

    @property
    def _proofs(self) -> int:
        """Whole arcs driven and looks that told something; one arc at least must be among them."""
        return self.arcs + self.looks if self.arcs else 0

    @property
    def ranking(self) -> list[tuple[float, int]]:
        """(log-likelihood, node), the likeliest first."""
        return sorted(
            ((score, node) for node, score in self.log_likelihood.items()), key=lambda e: (-e[0], e[1])
        )

    @property
    def estimate(self) -> int | None:
        """The node the robot is at, if what was met leaves no other; None if it is not sure."""
        ranking = self.ranking
        if not ranking or self._proofs < self.config.least_arcs:
            return None
        best, node = ranking[0]
        latest = self._latest[node]
        most = self.config.misfit
        least = max(1, self.config.least_arcs - self.looks)
        if len(latest) < least or sum(latest) < -most * len(latest):
            return None
        if min(latest) < -2.0 * most:
            return None
        if len(ranking) > 1 and best - ranking[1][0] < self.config.margin:
            return None
        return node

    @property
    def hypotheses(self) -> list[int]:
        """The nodes that explain what was met about as well as the best."""
        ranking = self.ranking
        return [node for score, node in ranking if ranking[0][0] - score < self.config.margin]

    @property
    def likely(self) -> list[int]:
        """The nodes that a few looks could bring to the front, and somewhat beyond; the best of many."""
        ranking = self.ranking
        least = ranking[0][0] - self.config.margin - 2.0 * self.config.floor
        return [node for score, node in ranking[:_MOST_SEEN] if score > least]

    def _deviation(self, length: float) -> float:
        return self.config.length_deviation + self.config.length_slope * length
