"""What training begins with: planes through the samples, grids, random weights."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ..errors import MapError
from .sample_space import SampleSpace

if TYPE_CHECKING:
    from .lattice import Floats, Lattice
    from .schedules import Start

_TURNS = (
    ((1.0, 0.0), (0.0, 1.0)),
    ((-1.0, 0.0), (0.0, -1.0)),
    ((0.0, -1.0), (1.0, 0.0)),
    ((0.0, 1.0), (-1.0, 0.0)),
)
"""The lattice as it is, then turned by a half, a quarter and three quarters."""


def starting_weights(
    lattice: Lattice,
    samples: Floats,
    start: Start,
    start_range: tuple[float, float],
    rng: np.random.Generator | None,
) -> Floats:
    """(units, dims) weights to begin with.

    pca: a plane through the mean along the two principal components (needs no rng). grid: evenly over the
    unit square, dimensions taking x and y in turn. random: uniform in `start_range`. samples: drawn ones.

    Raises: MapError without the rng that random and samples need.
    """
    dims = samples.shape[1]
    if start == "pca":
        space = SampleSpace.of(samples)
        return space.leave(principal_planes(lattice, space, 1))
    if start == "grid":
        place = lattice.positions
        span = np.maximum(place.max(axis=0), 1e-12)
        unit = np.where(place.max(axis=0) > 0.0, place / span, 0.5)
        return np.ascontiguousarray(unit[:, np.arange(dims) % 2])
    if rng is None:
        raise MapError(f"starting weights {start!r} are drawn: pass a numpy Generator as rng")
    if start == "random":
        return rng.uniform(*start_range, size=(lattice.units, dims))
    return samples[rng.integers(len(samples), size=lattice.units)].copy()


def principal_planes(lattice: Lattice, space: SampleSpace, starts: int) -> Floats:
    """(m, starts * units) coordinates of the lattice laid over the samples' two principal components.

    From the mean to two standard deviations either way. The first start has the lattice's longer side along
    the first component, the others turn it by a half, a quarter and three quarters.
    """
    return np.asarray(_principal_axes(space) @ _placements(lattice, starts))


@lru_cache(maxsize=8)
def _placements(lattice: Lattice, starts: int) -> Floats:
    """(2, starts * units) where on the plane units begin, in standard deviations."""
    placed = []
    for turn in _TURNS[:starts]:
        place = (lattice.positions - lattice.positions.mean(axis=0)) @ np.array(turn)
        if np.ptp(lattice.positions[:, 0]) < np.ptp(lattice.positions[:, 1]):
            place = place[:, ::-1]
        placed.append(2.0 * place.T / np.maximum(np.abs(place).max(axis=0), 0.5)[:, None])
    return np.hstack(placed)


def _principal_axes(space: SampleSpace) -> Floats:
    """(m, 2) coordinates of the two principal components, one standard deviation long; zero where none is."""
    count = len(space)
    matrix = space.dual if space.gram else space.around.T @ space.around
    values, vectors = np.linalg.eigh(matrix)
    values, vectors = np.maximum(values[::-1][:2], 0.0), vectors[:, ::-1][:, :2]
    scale = np.full(len(values), 1.0) if space.gram else np.sqrt(values)
    axes = np.zeros((len(matrix), 2))
    axes[:, : vectors.shape[1]] = vectors * (scale / np.sqrt(count))
    # Eigenvectors have no sign: the farthest sample lies ahead.
    along = np.abs(seen := space.dual @ axes)
    far = (along >= along.max(axis=0) * (1.0 - 1e-9)).argmax(axis=0)
    return axes * np.where(seen[far, np.arange(2)] < 0.0, -1.0, 1.0)
