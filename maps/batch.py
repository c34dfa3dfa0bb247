"""Batch SOM training (Kohonen 2001, section 3.6) and starting weights."""

from __future__ import annotations

import numpy as np

from .errors import MapError
from .lattice import Floats, Lattice
from .online import squared_distances
from .schedules import BatchConfig, Start


def train_batch(
    lattice: Lattice, weights: Floats, samples: Floats, config: BatchConfig
) -> tuple[Floats, int, bool]:
    """Trains from (units, dims) weights on (n, dims) samples: new weights, passes done, whether it settled.

    With n + units < dims everything but the last product is done on inner products (Gram form).
    """
    if len(samples) + lattice.units < samples.shape[1]:
        return _gram(lattice, weights, samples, config)
    squared = squared_distances(weights, samples)
    share = np.zeros_like(squared)
    radii = config.radii()
    winners = squared.argmin(axis=0)
    for done in range(1, config.max_passes + 1):
        share, reached = _share(lattice, radii[min(done, len(radii)) - 1], squared.argmin(axis=0))
        weights = np.where(reached[:, None], share @ samples, weights)
        squared = squared_distances(weights, samples)
        before, winners = winners, squared.argmin(axis=0)
        if done >= len(radii) and np.array_equal(before, winners):
            return weights, done, True
    return weights, config.max_passes, False


def _gram(
    lattice: Lattice, weights: Floats, samples: Floats, config: BatchConfig
) -> tuple[Floats, int, bool]:
    center = samples.mean(axis=0)
    around = samples - center
    inner = around @ around.T
    own = np.diagonal(inner)
    offset = weights - center
    squared = np.einsum("ij,ij->i", offset, offset)[:, None] - 2.0 * (offset @ around.T) + own
    radii = config.radii()
    winners = squared.argmin(axis=0)
    settled, done = False, 0
    share = np.zeros((lattice.units, len(samples)))
    while done < config.max_passes and not settled:
        done += 1
        share, _ = _share(lattice, radii[min(done, len(radii)) - 1], winners)
        product = share @ inner
        squared = np.einsum("ij,ij->i", product, share)[:, None] - 2.0 * product + own
        before, winners = winners, squared.argmin(axis=0)
        settled = done >= len(radii) and np.array_equal(before, winners)
    return center + share @ around, done, settled


def _share(
    lattice: Lattice, radius: float, winners: np.ndarray[tuple[int], np.dtype[np.int64]]
) -> tuple[Floats, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
    spread = np.exp(lattice.squared_distances[:, winners] * (-0.5 / (radius * radius)))
    total = spread.sum(axis=1)
    reached = total > 0.0
    return spread / np.where(reached, total, 1.0)[:, None], reached


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
        return _principal(lattice, samples)
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


def _principal(lattice: Lattice, samples: Floats) -> Floats:
    center = samples.mean(axis=0)
    around = samples - center
    count, dims = around.shape
    if count <= dims:  # the small of the two eigenproblems; both have the same nonzero part
        values, vectors = np.linalg.eigh(around @ around.T)
        values, vectors = values[::-1][:2], vectors[:, ::-1][:, :2]
        axes = (around.T @ vectors).T  # length sqrt(value)
    else:
        values, vectors = np.linalg.eigh(around.T @ around)
        values, vectors = values[::-1][:2], vectors[:, ::-1][:, :2]
        axes = vectors.T * np.sqrt(np.maximum(values, 0.0))[:, None]
    axes = axes / np.sqrt(count)
    largest = np.abs(axes).argmax(axis=1)
    axes *= np.where(axes[np.arange(len(axes)), largest] < 0.0, -1.0, 1.0)[
        :, None
    ]  # eigenvectors have no sign
    place = lattice.positions - lattice.positions.mean(axis=0)
    scale = 2.0 / np.maximum(np.abs(place).max(axis=0), 0.5)
    if np.ptp(lattice.positions[:, 0]) < np.ptp(lattice.positions[:, 1]):
        axes = axes[::-1]  # the longer side of the lattice takes the first component
    if len(axes) < 2:
        axes = np.vstack([axes, np.zeros((2 - len(axes), dims))])
    return np.asarray(center + (place * scale) @ axes)
