"""After batch training: units that win nothing take over samples that share a unit, if the topology allows.

With about as many units as samples, batch training leaves some units without samples while others hold
several. A free neighbor of a crowded unit is put onto the worst of its samples, as growing neural gas inserts
units next to the largest error (Fritzke 1995), but only when no sample more has its two best units apart on
the lattice. Then every unit goes to the mean of its samples, as often as that helps, on the same condition.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .lattice import Floats, Lattice
from .online import squared_distances

LIMIT = 256
"""Maps of more units or samples are left as they are: each move looks at all pairs."""

_SETTLING = 4


def fill(lattice: Lattice, weights: Floats, samples: Floats) -> Floats:
    """(units, dims) weights with a quantization and a topographic error no higher than before."""
    if len(samples) > LIMIT or not 1 < lattice.units <= LIMIT:
        return weights
    between = squared_distances(samples, samples)
    apart = squared_distances(weights, samples)
    weights = weights.copy()
    torn = _torn(lattice, apart)
    for mend in (True, False):  # first where the topology is torn, then wherever a unit is crowded
        torn = _move_free_units(lattice, weights, samples, apart, between, torn, mend)
    for _ in range(_SETTLING):
        winners = apart.argmin(axis=0)
        count = np.bincount(winners, minlength=lattice.units)
        members = (winners == np.arange(lattice.units)[:, None]) / np.maximum(count, 1)[:, None]
        centered = np.where(count[:, None] > 0, members @ samples, weights)
        settled = squared_distances(centered, samples)
        gain = float(np.sqrt(apart.min(axis=0)).sum() - np.sqrt(settled.min(axis=0)).sum())
        still = _torn(lattice, settled)
        if gain <= 0.0 or still.sum() > torn.sum():
            break
        weights, apart, torn = centered, settled, still
    return weights


def _torn(lattice: Lattice, apart: Floats) -> NDArray[np.bool_]:
    """(n,) whether each sample's best and second-best unit are no neighbors; apart: (units, n)."""
    columns = np.arange(apart.shape[1])
    first = apart.argmin(axis=0)
    kept = apart[first, columns]
    apart[first, columns] = np.inf
    second = apart.argmin(axis=0)
    apart[first, columns] = kept
    return np.asarray(~lattice.adjacency[first, second])


def _move_free_units(
    lattice: Lattice,
    weights: Floats,
    samples: Floats,
    apart: Floats,
    between: Floats,
    torn: NDArray[np.bool_],
    mend: bool,
) -> NDArray[np.bool_]:
    """Moves free units one at a time, in place, until no move helps; which samples are torn then."""
    refused: set[tuple[int, int]] = set()
    for _ in range(2 * lattice.units):
        winners, error = apart.argmin(axis=0), apart.min(axis=0)
        free = np.bincount(winners, minlength=lattice.units) == 0
        if not free.any():
            break
        wanting = [
            int(k) for k in np.argsort(-error, kind="stable") if error[k] > 1e-12 and (torn[k] or not mend)
        ]
        pairs = ((k, int(f)) for k in wanting for f in np.flatnonzero(lattice.adjacency[winners[k]] & free))
        for sample, unit in pairs:
            if (sample, unit) in refused:
                continue
            before = apart[unit].copy()
            apart[unit] = between[sample]
            now = _torn(lattice, apart)
            if now.sum() < torn.sum() or (not mend and now.sum() == torn.sum()):
                weights[unit], torn = samples[sample], now
                break
            apart[unit] = before
            refused.add((sample, unit))
        else:
            break
    return torn
