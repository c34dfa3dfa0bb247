"""Batch SOM training (Kohonen 2001, section 3.6) from several turned starts at once."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .dead_units import revive_dead_units

if TYPE_CHECKING:
    from .lattice import Floats, Ints, Lattice
    from .sample_space import SampleSpace
    from .schedules import BatchConfig

TORN_COUNTS = 4.0
"""A start that tears 1 % of the samples more must have an error lower by this many per cent to be kept."""


def train_batch(
    lattice: Lattice, space: SampleSpace, config: BatchConfig, scores: Floats
) -> tuple[Floats, int, bool]:
    """Trains on the samples of a space: (units, dims) new weights, passes done, whether it settled.

    scores: (n, starts * units) of the first weights, one start after another; the best start is kept.
    """
    coordinates, passes, settled = _passes(lattice, space, config, scores)
    best = _best(lattice, space, coordinates)
    if config.fill:
        best = revive_dead_units(lattice, best, space)
    return space.leave(best), passes, settled


def _passes(
    lattice: Lattice, space: SampleSpace, config: BatchConfig, scores: Floats
) -> tuple[Floats, int, bool]:
    """Coordinates (m, starts * units) after training from scores (n, starts * units) of the first weights."""
    schedule = _schedule(lattice, config) if lattice.shared else _steps(lattice, config)
    count, width = scores.shape
    winners = scores.reshape(count, -1, lattice.units).argmin(axis=2)
    coordinates, done, settled = np.empty((0, width)), 0, False
    for radius, table in schedule:
        spread = table.take(winners, axis=0).reshape(count, width)
        total = space.ones @ spread
        if total.min() == 0.0:
            spread, total = _far(lattice, radius, winners)
        coordinates = space.mixed(spread) / total
        scores = space.scores(coordinates)
        before, winners = winners, scores.reshape(count, -1, lattice.units).argmin(axis=2)
        done += 1
        settled = done >= config.passes and np.array_equal(before, winners)
        if settled:
            break
    return coordinates, done, settled


@lru_cache(maxsize=8)
def _schedule(lattice: Lattice, config: BatchConfig) -> tuple[tuple[float, Floats], ...]:
    return tuple(_steps(lattice, config))


def _steps(lattice: Lattice, config: BatchConfig) -> Iterator[tuple[float, Floats]]:
    """For each pass up to the cap: the radius, and the (units, units) Gaussian of the lattice distance."""
    table: Floats | None = None
    for radius in config.radii().tolist():
        table = np.exp(lattice.squared_distances * (-0.5 / (radius * radius)))
        yield radius, table
    assert table is not None
    for _ in range(config.max_passes - config.passes):
        yield radius, table


def _far(lattice: Lattice, radius: float, winners: Ints) -> tuple[Floats, Floats]:
    """The same shares where units lie so far from every winner that their Gaussians vanish."""
    squared = lattice.squared_distances[winners]  # (n, starts, units)
    spread = np.exp((squared - squared.min(axis=0)) * (-0.5 / (radius * radius))).reshape(len(winners), -1)
    return spread, spread.sum(axis=0)


def _best(lattice: Lattice, space: SampleSpace, coordinates: Floats) -> Floats:
    """Of the starts' coordinates (m, starts * units) those with the best fit that is also orderly."""
    starts = coordinates.shape[1] // lattice.units
    if starts == 1:
        return coordinates
    apart = space.apart(coordinates).reshape(len(space), starts, lattice.units)
    error = np.sqrt(apart.min(axis=2)).mean(axis=0)
    cost = error * (1.0 + TORN_COUNTS * lattice.torn(apart).mean(axis=0))
    first = int(cost.argmin()) * lattice.units
    return np.ascontiguousarray(coordinates[:, first : first + lattice.units])
