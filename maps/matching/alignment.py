"""Aligns two boundaries without a common frame: local alignment (Smith and Waterman 1981) on a cycle.

A pair of nodes scores by how much likelier their corner, turn and arc lengths are if the two are the same
place than by chance; skipping a node costs. The best alignment must beat the best one that pairs otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product
from typing import TYPE_CHECKING

from ..errors import NoMatchError

if TYPE_CHECKING:
    from ..boundary.walk import Boundary

SAME_CORNER, OTHER_CORNER = math.log(0.97 / 0.5), math.log(0.03 / 0.5)
TURN_SIGMA = math.radians(15.0)
WORST_TURN = -4.0
LENGTH_SIGMA, LENGTH_SHARE = 0.02, 0.04
"""An arc's length in two maps differs by about the larger of 2 cm and 4 %."""

TYPICAL_LENGTH = 0.4
"""Spread (m) of lengths that have nothing to do with each other."""

WORST_LENGTH = -6.0
SKIP = -3.0
MARGIN = 4.0
"""Nats by which the best alignment must beat the best that pairs otherwise."""

MOST_RIVALS = 8
MOST_CELLS = 1_000_000
MOST_SKIPPED = 2
"""Nodes that may be missing on either side between two pairs."""

_STEPS = range(1, MOST_SKIPPED + 2)


@dataclass(frozen=True, slots=True)
class Alignment:
    """pairs: (index in the one boundary, index in the other), in order. score: nats above chance."""

    pairs: tuple[tuple[int, int], ...]
    score: float

    def agreement(self, other: Alignment) -> float:
        """Share of the smaller one's pairs that the other has too."""
        return len(set(self.pairs) & set(other.pairs)) / max(1, min(len(self.pairs), len(other.pairs)))


def align(one: Boundary, other: Boundary) -> list[Alignment]:
    """The best alignment, then the best of those that agree with less than half of each before.

    Goes on while they are as good as the best within MARGIN, and to the first that is not.
    """
    found: list[Alignment] = []
    for raw in _all_alignments(one, other):
        if all(raw.agreement(known) < 0.5 for known in found):
            found.append(_close_gaps(one, other, raw))
            if raw.score < found[0].score - MARGIN or len(found) == MOST_RIVALS + 1:
                break
    return found


def _all_alignments(one: Boundary, other: Boundary) -> Iterator[Alignment]:
    """Every alignment that ends somewhere, best first; the boundaries are unrolled twice when closed."""
    rows = len(one) * (2 if one.closed else 1)
    cols = len(other) * (2 if other.closed else 1)
    if rows * cols > MOST_CELLS:
        raise NoMatchError(f"boundaries of {len(one)} and {len(other)} nodes: too long to be aligned")
    score: dict[tuple[int, int], float] = {}
    came: dict[tuple[int, int], tuple[int, int] | None] = {}
    start: dict[tuple[int, int], tuple[int, int]] = {}
    single = [[_pair_score(one, i, other, j) for j in range(len(other))] for i in range(len(one))]
    steps = [(k, m, _step_scores(one, k, other, m)) for k in _STEPS for m in _STEPS]
    for i in range(rows):
        for j in range(cols):
            best, before = 0.0, None
            for k, m, gained in steps:
                at = (i - k, j - m)
                if at not in score or i - start[at][0] >= len(one) or j - start[at][1] >= len(other):
                    continue
                value = score[at] + gained[at[0] % len(one)][at[1] % len(other)]
                if value > best:
                    best, before = value, at
            score[i, j] = best + single[i % len(one)][j % len(other)]
            came[i, j] = before
            start[i, j] = (i, j) if before is None else start[before]
    for at in sorted(score, key=lambda at: (-score[at], at)):
        if score[at] <= 0.0:
            return
        yield _trace(at, came, score[at], len(one), len(other))


def _step_scores(one: Boundary, k: int, other: Boundary, m: int) -> list[list[float]]:
    """What going k nodes on from i and m nodes on from j gains, as table [i][j]."""
    ends = [other.between(j, j + m) for j in range(len(other))]
    skipping = (k + m - 2) * SKIP
    return [[skipping + _length_score(one.between(i, i + k), end) for end in ends] for i in range(len(one))]


def _close_gaps(one: Boundary, other: Boundary, found: Alignment) -> Alignment:
    """Adds pairs in the gaps, the one around the start too, whose lengths to both sides fit.

    Next to skipped nodes a pair alone may score less than the skipping costs, and the local alignment, which
    has no end on a cycle, rather stops there.
    """
    pairs = list(found.pairs)
    around = one.closed and other.closed
    for start, end in list(pairwise(pairs)) + ([(pairs[-1], pairs[0])] if around else []):
        gap = (end[0] - start[0] - 1) % len(one), (end[1] - start[1] - 1) % len(other)
        at = (0, 0)
        for a, b in sorted(product(range(1, gap[0] + 1), range(1, gap[1] + 1)), key=sum):
            if a > at[0] and b > at[1] and len(pairs) < min(len(one), len(other)):
                node = (start[0] + a) % len(one), (start[1] + b) % len(other)
                fits = (
                    one.corners[node[0]] == other.corners[node[1]]
                    and _pair_score(one, node[0], other, node[1]) > 0.0
                    and _span_score(one, start[0] + at[0], a - at[0], other, start[1] + at[1], b - at[1])
                    > 0.0
                    and _span_score(one, start[0] + a, gap[0] + 1 - a, other, start[1] + b, gap[1] + 1 - b)
                    > 0.0
                )
                if fits:
                    pairs.append(node)
                    at = (a, b)
    return Alignment(tuple(pairs), found.score)


def _span_score(one: Boundary, i: int, steps: int, other: Boundary, j: int, others: int) -> float:
    return _length_score(one.between(i, i + steps), other.between(j, j + others))


def _trace(
    at: tuple[int, int],
    came: dict[tuple[int, int], tuple[int, int] | None],
    score: float,
    rows: int,
    cols: int,
) -> Alignment:
    pairs = []
    step: tuple[int, int] | None = at
    while step is not None:
        pairs.append((step[0] % rows, step[1] % cols))
        step = came[step]
    return Alignment(tuple(reversed(pairs)), score)


def _pair_score(one: Boundary, i: int, other: Boundary, j: int) -> float:
    corner = SAME_CORNER if one.corners[i] == other.corners[j] else OTHER_CORNER
    off = math.remainder(one.turns[i] - other.turns[j], math.tau) / TURN_SIGMA
    return corner + max(WORST_TURN, -0.5 * off * off)


def _length_score(one: float, other: float) -> float:
    sigma = math.sqrt(2.0) * max(LENGTH_SIGMA, LENGTH_SHARE * 0.5 * (one + other))
    off = (one - other) / sigma
    return max(WORST_LENGTH, math.log(TYPICAL_LENGTH / (sigma * math.sqrt(math.tau))) - 0.5 * off * off)
