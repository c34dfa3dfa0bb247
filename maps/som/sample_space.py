"""Samples in the coordinates that are cheapest to train in.

Training moves units to means of samples and asks for distances: it needs inner products alone. Few long
samples are therefore told by their Gram matrix, and a unit by its share of each sample; many short ones as
they are. Exact up to rounding either way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from .lattice import Floats


@dataclass(frozen=True, slots=True)
class SampleSpace:
    """n samples around their mean. Coordinates of weights are columns (m, units): m = dims, n in Gram form.

    dual: (n, m) inner products of the samples with the unit vectors of the coordinates. own: (n,) squared
    lengths. ones: (n,) of them, for sums over samples.
    """

    center: Floats
    around: Floats
    dual: Floats
    own: Floats
    ones: Floats
    gram: bool

    @classmethod
    def of(cls, samples: Floats) -> Self:
        """The space of (n, dims) samples."""
        center = samples.mean(axis=0)
        around = samples - center
        ones = np.ones(len(samples))
        if len(samples) >= samples.shape[1]:
            return cls(center, around, around, np.einsum("ij,ij->i", around, around), ones, False)
        inner = around @ around.T
        return cls(center, around, inner, np.diagonal(inner).copy(), ones, True)

    def __len__(self) -> int:
        """How many samples there are."""
        return len(self.own)

    def mixed(self, shares: Floats) -> Floats:
        """(m, k) coordinates of k mixtures, the columns of shares (n, k)."""
        return shares if self.gram else self.around.T @ shares

    def scores(self, coordinates: Floats) -> Floats:
        """(n, k) squared distances from samples to coordinates (m, k), less the samples' squared lengths."""
        cross = self.dual @ coordinates
        norms = np.einsum("ij,ij->j", cross if self.gram else coordinates, coordinates)
        cross *= -2.0
        cross += norms
        return cross

    def scores_of(self, weights: Floats) -> Floats:
        """(n, units) the same for weights (units, dims) that need not be mixtures of the samples."""
        offset = weights - self.center
        return np.asarray(np.einsum("ij,ij->i", offset, offset) - 2.0 * (self.around @ offset.T))

    def apart(self, coordinates: Floats) -> Floats:
        """(n, k) squared distances from samples to coordinates (m, k)."""
        scores = self.scores(coordinates)
        scores += self.own[:, None]
        return np.asarray(np.maximum(scores, 0.0, out=scores))

    def between(self) -> Floats:
        """(n, n) squared distances between the samples."""
        inner = self.dual if self.gram else self.around @ self.around.T
        return np.asarray(np.maximum(self.own[:, None] + self.own - 2.0 * inner, 0.0))

    def point(self, sample: int) -> Floats:
        """(m,) coordinates of a sample."""
        if not self.gram:
            return np.asarray(self.around[sample])
        alone = np.zeros(len(self))
        alone[sample] = 1.0
        return alone

    def leave(self, coordinates: Floats) -> Floats:
        """(units, dims) weights from coordinates (m, units)."""
        return np.asarray(self.center + (coordinates.T @ self.around if self.gram else coordinates.T))
