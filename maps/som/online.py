"""Online SOM training, step by step as the thesis has it; in Gram form where samples are few and long.

Gram form: the winner depends on distances alone, and a move of w toward sample s by a changes its squared
distance to sample k by (1-a) d(w,k) + a d(s,k) - a (1-a) d(w,s). So the distances are carried along, and the
weights are multiplied out once at the end. Exact up to rounding; the cost does not grow with the dimensions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .lattice import Floats, Ints, Lattice
    from .schedules import OnlineConfig


def train_online(
    lattice: Lattice, weights: Floats, samples: Floats, config: OnlineConfig, rng: np.random.Generator
) -> tuple[Floats, int, bool]:
    """Trains (units, dims) weights on (n, dims) samples: new weights, steps done, whether it converged."""
    count, dims = samples.shape
    if config.order == "sequence":
        order = np.resize(np.arange(count), config.max_steps)
    else:
        order = rng.integers(count, size=config.max_steps)
    run = _gram if count + lattice.units < dims else _direct
    return run(lattice, weights, samples, config, order)


Near = Callable[[int], "Floats"]
"""(units,) how much each unit moves along with a winner, 1 for the winner itself."""


def _gains(lattice: Lattice, config: OnlineConfig) -> Iterator[tuple[Near | None, float]]:
    """For each step: who moves along with the winner (None: the winner alone), and the rate."""
    bubble = (lattice.steps <= config.radius).astype(np.float64)
    squared = lattice.squared_distances
    last, table = 0.0, bubble
    for rate, radius in zip(config.rates().tolist(), config.radii().tolist(), strict=True):
        if config.neighborhood == "bubble":
            yield (bubble.__getitem__ if radius > 0.0 else None), rate
        elif radius < 0.12:  # exp(-1 / (2 * 0.12^2)) is 1e-15: nobody but the winner moves
            yield None, rate
        elif radius != last:
            last, table = radius, np.empty(0)
            yield partial(_gaussian, squared, -0.5 / (radius * radius)), rate
        else:  # it has ceased to shrink: one table serves all further steps
            table = table if len(table) else np.exp(squared * (-0.5 / (radius * radius)))
            yield table.__getitem__, rate


def _gaussian(squared: Floats, factor: float, winner: int) -> Floats:
    return np.asarray(np.exp(squared[winner] * factor))


def _direct(
    lattice: Lattice, weights: Floats, samples: Floats, config: OnlineConfig, order: Ints
) -> tuple[Floats, int, bool]:
    weights = weights.copy()
    count, moved, step = len(samples), 0.0, 0
    for step, (index, (near, rate)) in enumerate(
        zip(order.tolist(), _gains(lattice, config), strict=True), 1
    ):
        difference = samples[index] - weights
        squared = np.einsum("ij,ij->i", difference, difference)
        winner = int(squared.argmin())
        if near is None:
            weights[winner] += rate * difference[winner]
            moved += rate * float(squared[winner]) ** 0.5
        else:
            gain = rate * near(winner)
            weights += gain[:, None] * difference
            moved += float(gain @ np.sqrt(squared))
        if step % count == 0:
            if moved / (count * lattice.units) < config.stop_delta:
                return weights, step, True
            moved = 0.0
    return weights, step, False


def _gram(
    lattice: Lattice, weights: Floats, samples: Floats, config: OnlineConfig, order: Ints
) -> tuple[Floats, int, bool]:
    between = squared_distances(samples, samples)
    apart = squared_distances(weights, samples)
    gains = np.zeros((config.max_steps, lattice.units))
    count, moved, step, converged = len(samples), 0.0, 0, False
    for step, (index, (near, rate)) in enumerate(
        zip(order.tolist(), _gains(lattice, config), strict=True), 1
    ):
        squared = apart[:, index]
        winner = int(squared.argmin())
        if near is None:
            gains[step - 1, winner] = rate
            own, row = float(squared[winner]), apart[winner]
            row *= 1.0 - rate
            row += rate * between[index] - rate * (1.0 - rate) * own
            moved += rate * max(own, 0.0) ** 0.5
        else:
            gain = gains[step - 1]
            np.multiply(near(winner), rate, out=gain)
            keep = 1.0 - gain
            moved += float(gain @ np.sqrt(np.maximum(squared, 0.0)))
            offset = gain * keep * squared
            apart *= keep[:, None]
            apart += gain[:, None] * between[index]
            apart -= offset[:, None]
        if step % count == 0:
            converged = moved / (count * lattice.units) < config.stop_delta
            if converged:
                break
            moved = 0.0
    return _multiply_out(weights, samples, gains[:step], order[:step]), step, converged


def _multiply_out(weights: Floats, samples: Floats, gains: Floats, order: Ints) -> Floats:
    """Weights after steps of (steps, units) gains toward samples[order]."""
    kept = np.cumprod((1.0 - gains)[::-1], axis=0)[::-1]
    share = gains.copy()
    share[:-1] *= kept[1:]
    by_sample = np.zeros((len(samples), weights.shape[0]))
    np.add.at(by_sample, order, share)
    return np.asarray(kept[0][:, None] * weights + by_sample.T @ samples)


def squared_distances(left: Floats, right: Floats) -> Floats:
    """(len(left), len(right)) squared Euclidean distances; exact for few dimensions, expanded for many."""
    if left.shape[1] <= 8:
        difference = left[:, None, :] - right[None, :, :]
        return np.asarray(np.einsum("ijk,ijk->ij", difference, difference))
    squared = np.einsum("ij,ij->i", left, left)[:, None] + np.einsum("ij,ij->i", right, right)[None, :]
    squared -= 2.0 * (left @ right.T)
    return np.asarray(np.maximum(squared, 0.0))
