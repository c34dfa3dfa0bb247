"""Compares two maps of the same world without a common coordinate frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..boundary.walk import Boundary, boundaries, mean_angle
from ..errors import NoMatchError
from .alignment import MARGIN, Alignment, align
from .frames import Frames, has_place

if TYPE_CHECKING:
    from ..hybrid_map import HybridMap
    from ..local.local_map import LocalMap

LEAST_MATCHED = 0.6
"""Share of the nodes of the larger closed boundary (of the smaller one, if either is open) to be matched."""

LEAST_PAIRS = 4
LOOKS_ALIKE = 0.75
"""Without that margin the views decide, if those of the one alignment are this much closer."""


@dataclass(frozen=True, slots=True)
class ArcDifference:
    """An arc between matched nodes; distances in m, standard deviation of their difference in m."""

    one: tuple[int, int]
    other: tuple[int, int]
    distance_one: float
    distance_other: float
    sigma: float

    @property
    def differs(self) -> bool:
        """Whether the distances differ by more than three standard deviations."""
        return abs(self.distance_one - self.distance_other) > 3.0 * self.sigma


@dataclass(frozen=True, slots=True)
class Comparison:
    """What two maps have in common. matched: node of the one -> node of the other.

    only_one, only_other: nodes without a partner. rotation: heading in the other's map frame minus heading in
    the one's, rad. score, rival: nats of the alignment and of the best that pairs otherwise.
    """

    matched: dict[int, int]
    only_one: tuple[int, ...]
    only_other: tuple[int, ...]
    arcs: tuple[ArcDifference, ...]
    rotation: float
    score: float
    rival: float

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "matched": [[one, other] for one, other in sorted(self.matched.items())],
            "only_a": list(self.only_one),
            "only_b": list(self.only_other),
            "arcs": [
                {
                    "a": list(arc.one),
                    "b": list(arc.other),
                    "distance_a_m": arc.distance_one,
                    "distance_b_m": arc.distance_other,
                    "differs": arc.differs,
                }
                for arc in self.arcs
            ],
            "rotation_rad": self.rotation,
            "score": self.score,
            "rival_score": self.rival,
        }


def compare(one: HybridMap, other: HybridMap) -> Comparison:
    """Matches the nodes of two maps by their corners, turns, arc lengths and, where those leave doubt, views.

    Raises: NoMatchError when they seem to be of different worlds, or match in more than one way.
    """
    left = sorted(boundaries(one), key=lambda boundary: has_place(one, boundary))  # those of islands last
    right = sorted(boundaries(other), key=lambda boundary: has_place(other, boundary))
    if not left or not right:
        raise NoMatchError(
            "a map without a boundary (two nodes joined by right-hand arcs) cannot be compared"
        )
    matched: dict[int, int] = {}
    best, rival = _decide(one, left[0], other, right[0])
    matched.update(_nodes(left[0], right[0], best))
    frames = Frames(one, other, matched, rotation(one, other, matched))
    taken = {0}
    for boundary in left[1:]:  # free-standing obstacles: matched when clear, left out when not
        for index, partner in enumerate(right):
            if index in taken:
                continue
            pairs = _obstacle(one, boundary, other, partner, frames)
            if pairs:
                matched.update(pairs)
                taken.add(index)
                break
    return Comparison(
        matched,
        tuple(node for node in one.nodes() if node not in matched),
        tuple(node for node in other.nodes() if node not in matched.values()),
        tuple(_arc_differences(one, other, matched)),
        rotation(one, other, matched),
        best.score,
        rival,
    )


def _obstacle(
    one: HybridMap, left: Boundary, other: HybridMap, right: Boundary, frames: Frames
) -> dict[int, int]:
    """The matched nodes of a free-standing obstacle: by its place if both maps know it, else by its shape."""
    if has_place(one, left) and has_place(other, right):
        found = frames.match(left, right)
        return found if len(found) >= LEAST_MATCHED * max(len(left), len(right)) else {}
    try:
        return _nodes(left, right, _decide(one, left, other, right)[0])
    except NoMatchError:
        return {}


def _nodes(one: Boundary, other: Boundary, alignment: Alignment) -> dict[int, int]:
    return {one.nodes[i]: other.nodes[j] for i, j in alignment.pairs}


def _decide(one: HybridMap, left: Boundary, other: HybridMap, right: Boundary) -> tuple[Alignment, float]:
    """The alignment that holds, and the score of the best that pairs otherwise. Raises: NoMatchError."""
    size = max(len(left), len(right)) if left.closed and right.closed else min(len(left), len(right))
    needed = max(LEAST_PAIRS, math.ceil(LEAST_MATCHED * size))
    ranked = align(left, right)
    most = len(ranked[0].pairs) if ranked else 0
    if most < needed:
        raise NoMatchError(
            f"the maps do not seem to be of one world: {most} nodes match, {needed} are needed"
        )
    rival = ranked[1].score if len(ranked) > 1 else 0.0
    close = [
        found for found in ranked if ranked[0].score - found.score < MARGIN and len(found.pairs) >= needed
    ]
    if len(close) == 1:
        return ranked[0], rival
    looks = [_unlikeness(one, other, _nodes(left, right, found)) for found in close]
    known = sorted((look, index) for index, look in enumerate(looks) if look is not None)
    if len(known) == len(close) and known[0][0] <= LOOKS_ALIKE * known[1][0]:
        return close[known[0][1]], rival
    raise NoMatchError(
        f"the maps match in {len(close)} ways ({ranked[0].score:.1f} against {rival:.1f} nats,"
        f" {MARGIN:.0f} more needed) and the views do not decide"
    )


def _unlikeness(one: HybridMap, other: HybridMap, matched: dict[int, int]) -> float | None:
    """Mean distance of matched nodes' entry panoramas, turned into the same direction; None without any."""
    turn = rotation(one, other, matched)
    apart = []
    for a, b in matched.items():
        views = [_entry_view(one.local_map(a)), _entry_view(other.local_map(b))]
        if views[0] is None or views[1] is None:
            continue
        ahead = other.graph.nodes[b]["entry_heading"] - turn - one.graph.nodes[a]["entry_heading"]
        quarters = round(ahead / (math.pi / 2.0))
        apart.append(float(np.linalg.norm(views[0] - np.roll(views[1], quarters, axis=0))))
    return float(np.mean(apart)) if apart else None


def _entry_view(local: LocalMap | None) -> Any:
    return None if local is None else local.entry_panorama


def rotation(one: HybridMap, other: HybridMap, matched: dict[int, int]) -> float:
    """Heading in the other's map frame minus heading in the one's, rad, from the matched nodes' entries.

    A map made along the left-hand wall enters a corner the opposite way: reversed and turned by the corner.
    """
    offsets = []
    for a, b in matched.items():
        expected = one.graph.nodes[a]["entry_heading"]
        if one.meta.side != other.meta.side:
            expected += one.graph.nodes[a]["turn"] + math.pi
        offsets.append(other.graph.nodes[b]["entry_heading"] - expected)
    return mean_angle(offsets)


def _arc_differences(one: HybridMap, other: HybridMap, matched: dict[int, int]) -> list[ArcDifference]:
    found = []
    for arc in one.arcs():
        a, b = matched.get(arc.start), matched.get(arc.end)
        if arc.kind != "right" or a is None or b is None or not other.graph.has_edge(a, b, "right"):
            continue
        partner = other.arc(a, b, "right")
        sigma = math.sqrt(
            arc.variance / max(1, arc.traversals) + partner.variance / max(1, partner.traversals)
        )
        found.append(
            ArcDifference((arc.start, arc.end), (a, b), arc.distance, partner.distance, max(sigma, 0.005))
        )
    return found
