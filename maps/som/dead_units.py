"""Dead units: after batch training, units that win nothing take over samples that share a unit.

With about as many units as samples, batch training leaves some units without samples while others hold
several. A dead unit beside a crowded one is put onto the worst of its samples, as growing neural gas inserts
units next to the largest error (Fritzke 1995), but only where that tears no further sample (whose two best
units would no longer be neighbors). Then every unit goes to the mean of its samples, as often as that helps,
on the same condition.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .lattice import Floats, Ints, Lattice
    from .sample_space import SampleSpace

LIMIT = 256
"""Maps of more units or samples are left as they are: each move looks at all pairs."""

_SETTLING = 2


def revive_dead_units(lattice: Lattice, coordinates: Floats, space: SampleSpace) -> Floats:
    """(m, units) coordinates with a quantization and a topographic error no higher than before."""
    if len(space) > LIMIT or not 2 < lattice.units <= LIMIT:
        return coordinates
    coordinates, apart, between = coordinates.copy(), space.apart(coordinates), space.between()
    _move_dead_units(lattice, coordinates, space, apart, between)
    return _settle(lattice, coordinates, space, apart)


def _settle(lattice: Lattice, coordinates: Floats, space: SampleSpace, apart: Floats) -> Floats:
    """Moves all units to the means of what they win, while that helps; apart: (n, units) as they are."""
    torn = int(lattice.torn(apart).sum())
    error = float(np.sqrt(apart.min(axis=1)).sum())
    for _ in range(_SETTLING):
        members = (apart.argmin(axis=1)[:, None] == np.arange(lattice.units)).astype(np.float64)
        count = members.sum(axis=0)
        centered = np.where(count > 0.0, space.mixed(members / np.maximum(count, 1.0)), coordinates)
        moved = space.apart(centered)
        moved_error, moved_torn = float(np.sqrt(moved.min(axis=1)).sum()), int(lattice.torn(moved).sum())
        if moved_error >= error or moved_torn > torn:
            break
        coordinates, apart, error, torn = centered, moved, moved_error, moved_torn
    return coordinates


def _move_dead_units(
    lattice: Lattice, coordinates: Floats, space: SampleSpace, apart: Floats, between: Floats
) -> None:
    """Moves dead units one at a time, in place, until no move helps; those that join a torn sample first."""
    for _ in range(2 * lattice.units):
        order, far = _three_best(apart)
        winners = order[:, 0]
        dead = np.bincount(winners, minlength=lattice.units) == 0
        worst = np.argsort(-far[:, 0], kind="stable")
        worst = worst[far[worst, 0] > 1e-12]
        rows, units = np.nonzero(lattice.adjacency[winners[worst]] & dead)
        if not len(rows):
            return
        samples = worst[rows]
        torn = int(np.count_nonzero(~lattice.adjacency[winners, order[:, 1]]))
        left = _torn_after(lattice, order, far, between[samples], units)
        at = int((left < torn).argmax() or (left <= torn).argmax())
        if left[at] > torn:
            return
        coordinates[:, units[at]] = space.point(int(samples[at]))
        apart[:, units[at]] = between[samples[at]]


def _three_best(apart: Floats) -> tuple[Ints, Floats]:
    """(n, 3) the best units of each sample and their squared distances, of (n, units)."""
    each, rest = np.arange(len(apart)), apart.copy()
    order, far = np.empty((len(apart), 3), dtype=np.int64), np.empty((len(apart), 3))
    for place in range(3):
        best = rest.argmin(axis=1)
        order[:, place], far[:, place] = best, rest[each, best]
        rest[each, best] = np.inf
    return order, far


def _torn_after(lattice: Lattice, order: Ints, far: Floats, moved: Floats, units: Ints) -> NDArray[np.int64]:
    """(moves,) how many samples are torn once dead `units` lie at distances `moved` (moves, n), each alone.

    order, far: (n, 3) each sample's best units now and their squared distances.
    """
    was_second = order[:, 1] == units[:, None]
    second = np.where(was_second, order[:, 2], order[:, 1])
    limit = np.where(was_second, far[:, 2], far[:, 1])
    nearer = (moved < limit) | ((moved == limit) & (units[:, None] < second))
    other = np.where(nearer, units[:, None], second)
    return np.asarray((~lattice.adjacency[order[:, 0], other]).sum(axis=1))
