"""Self-organizing maps: section 3.4.3 of the thesis, and a batch default that is faster and more exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MapError, NotTrainedError
from .batch import train_batch
from .initialization import principal_planes, starting_weights
from .lattice import Floats, Ints, Topology, frozen, lattice_of
from .online import squared_distances, train_online
from .sample_space import SampleSpace
from .schedules import BATCH, Config, OnlineConfig

Method = Literal["best", "nearest", "radial"]

LARGEST = 1e150
"""Values beyond have no squares."""


@dataclass(frozen=True, slots=True)
class Training:
    """How the last training went. steps: online steps or batch passes; capped: stopped by the cap alone."""

    samples: int
    steps: int
    converged: bool

    @property
    def capped(self) -> bool:
        """Whether only the cap ended it."""
        return not self.converged


class SOM:
    """A self-organizing map: weights (units, dims) on a hexagonal or rectangular lattice, 1-d or 2-d.

    `fit` starts over, `partial_fit` goes on from the weights there are; `transform` and `predict` as in
    scikit-learn. Plain data throughout: what is saved is the lattice and the weights.
    """

    def __init__(
        self, rows: int = 5, cols: int = 5, topology: Topology = "hexagonal", weights: ArrayLike | None = None
    ) -> None:
        """An untrained map, or a trained one when weights (units, dims) are given. Raises: MapError."""
        self.lattice = lattice_of(rows, cols, topology)
        self.training: Training | None = None
        self._weights: NDArray[np.floating] | None = None
        if weights is not None:
            self._weights = self._checked_weights(weights)

    def __repr__(self) -> str:
        """Its shape and what it holds: `SOM(5 x 5, hexagonal, 2 dimensions)`."""
        told = "untrained" if self._weights is None else f"{self._weights.shape[1]} dimensions"
        return f"SOM({self.rows} x {self.cols}, {self.topology}, {told})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by lattice and weights, so that whoever unpickles it checks them."""
        shape = self.rows, self.cols, self.topology, self._weights
        return type(self), shape, {"training": self.training}

    @classmethod
    def train(
        cls,
        samples: ArrayLike,
        config: Config = BATCH,
        rng: np.random.Generator | None = None,
        *,
        rows: int = 5,
        cols: int = 5,
        topology: Topology = "hexagonal",
    ) -> Self:
        """A new map trained on (n, dims) samples; the rng is needed by online training and random starts."""
        return cls(rows, cols, topology).fit(samples, config, rng)

    @property
    def rows(self) -> int:
        """Rows of the lattice."""
        return self.lattice.rows

    @property
    def cols(self) -> int:
        """Columns of the lattice."""
        return self.lattice.cols

    @property
    def topology(self) -> Topology:
        """`hexagonal` or `rectangular`."""
        return self.lattice.topology

    @property
    def weights(self) -> NDArray[np.floating]:
        """(units, dims), read-only. Raises: NotTrainedError."""
        if self._weights is None:
            raise NotTrainedError("this SOM has no weights yet: call fit, or pass weights")
        return self._weights

    @property
    def units(self) -> int:
        """How many units there are."""
        return self.lattice.units

    def fit(self, samples: ArrayLike, config: Config = BATCH, rng: np.random.Generator | None = None) -> Self:
        """Trains on (n, dims) samples from the config's starting weights. Raises: MapError."""
        data = self._checked_samples(samples)
        start = None
        if config.start != "pca" or isinstance(config, OnlineConfig):
            start = starting_weights(self.lattice, data, config.start, config.start_range, rng)
        return self._run(start, data, config, rng)

    def partial_fit(
        self, samples: ArrayLike, config: Config = BATCH, rng: np.random.Generator | None = None
    ) -> Self:
        """Goes on from the present weights with (n, dims) new samples. Raises: MapError."""
        data = self._checked_samples(samples, like_weights=True)
        return self._run(self.weights.astype(np.float64), data, config, rng)

    def _run(
        self, start: Floats | None, data: Floats, config: Config, rng: np.random.Generator | None
    ) -> Self:
        if isinstance(config, OnlineConfig):
            assert start is not None
            if rng is None and config.order == "random":
                raise MapError("online training draws its samples: pass a numpy Generator as rng")
            source = rng if rng is not None else np.random.default_rng(0)
            weights, steps, converged = train_online(self.lattice, start, data, config, source)
        else:
            space = SampleSpace.of(data)
            if start is None:
                scores = space.scores(principal_planes(self.lattice, space, config.starts))
            else:
                scores = space.scores_of(start)
            weights, steps, converged = train_batch(self.lattice, space, config, scores)
        self._weights = frozen(np.ascontiguousarray(weights))
        self.training = Training(len(data), steps, converged)
        return self

    def transform(self, samples: ArrayLike) -> Floats:
        """(n, units) Euclidean distances from samples (n, dims) to the units."""
        data = self._checked_samples(samples, like_weights=True)
        return np.sqrt(squared_distances(data, self.weights.astype(np.float64)))

    def winners(self, samples: ArrayLike) -> Ints:
        """(n,) the best-matching unit of each sample (eq. 3.20); the lowest index of equals."""
        return np.asarray(self.transform(samples).argmin(axis=1))

    predict = winners

    def nearest(self, sample: ArrayLike, k: int = 1) -> tuple[Ints, Floats]:
        """The k best units of one sample (dims,), best first, and their distances."""
        if not 1 <= k <= self.units:
            raise MapError(f"k = {k}: from 1 to the {self.units} units there are")
        one = self._checked_samples(np.asarray(sample, dtype=np.float64)[None, :], like_weights=True)[0]
        difference = self.weights - one
        distances = np.sqrt(np.einsum("ij,ij->i", difference, difference))
        order = np.argsort(distances, kind="stable")[:k]
        return order.astype(np.int64), distances[order]

    def locate(
        self,
        sample: ArrayLike,
        values: ArrayLike,
        method: Method = "best",
        k: int = 3,
        width: float | None = None,
    ) -> Floats:
        """(m,) the value at one sample (dims,), from values (units, m) tied to units; NaN rows are skipped.

        best: the value of the best unit that has one (eq. 3.34). nearest: mean of the k best, weighted by
        1/distance. radial: normalized Gaussian radial basis functions of `width` (the units' own spacing when
        None). Raises: MapError when no unit has a value.
        """
        table = np.asarray(values, dtype=np.float64)
        if table.ndim != 2 or len(table) != self.units:
            raise MapError(f"values of shape {table.shape}: expected ({self.units}, m), one row a unit")
        tied = np.flatnonzero(~np.isnan(table).any(axis=1))
        if not len(tied):
            raise MapError("no unit of this SOM has a value to locate by")
        order, distances = self.nearest(sample, self.units)
        has = np.isin(order, tied)
        order, distances = order[has], distances[has]
        if k < 1 or not (width is None or 0.0 < width < np.inf):
            raise MapError(f"k = {k}, width = {width}: k from 1, and a width that is positive and finite")
        if method == "best":
            return np.asarray(table[order[0]])
        if method == "nearest":
            share = 1.0 / np.maximum(distances[:k], 1e-12)
            return np.asarray(share @ table[order[:k]] / share.sum())
        if method != "radial":
            raise MapError(f"unknown method {method!r}; known: best, nearest, radial")
        scale = self._spacing(tied) if width is None else width
        share = np.exp((distances[0] ** 2 - distances**2) / (2.0 * scale * scale))
        return np.asarray(share @ table[order] / share.sum())

    def _spacing(self, tied: Ints) -> float:
        """Half the mean distance from a unit with a value to its nearest fellow; 1 when there is one only."""
        if len(tied) < 2:
            return 1.0
        chosen = self.weights[tied].astype(np.float64)
        squared = squared_distances(chosen, chosen)
        np.fill_diagonal(squared, np.inf)
        return max(0.5 * float(np.sqrt(squared.min(axis=1)).mean()), 1e-12)

    def quantization_error(self, samples: ArrayLike) -> float:
        """Mean distance from a sample to its best unit."""
        data = self._checked_samples(samples, like_weights=True)
        apart = data - self.weights[self.winners(data)]
        return float(np.sqrt(np.einsum("ij,ij->i", apart, apart)).mean())

    def topographic_error(self, samples: ArrayLike) -> float:
        """Share of samples whose best and second-best units are no neighbors; 0 for a map of one unit."""
        if self.units == 1:
            return 0.0
        pairs = self._best_pairs(samples)
        return float(1.0 - self.lattice.adjacency[pairs[:, 0], pairs[:, 1]].mean())

    def hits(self, samples: ArrayLike) -> Ints:
        """(units,) how many samples each unit wins."""
        return np.bincount(self.winners(samples), minlength=self.units)

    def kept_edges(self, samples: ArrayLike) -> Ints:
        """(edges, 2) lattice edges that some sample has as best and second-best unit; smaller first."""
        if self.units == 1:
            return np.empty((0, 2), dtype=np.int64)
        pairs = np.sort(self._best_pairs(samples), axis=1)
        return np.unique(pairs[self.lattice.adjacency[pairs[:, 0], pairs[:, 1]]], axis=0)

    def _best_pairs(self, samples: ArrayLike) -> Ints:
        return np.argsort(self.transform(samples), axis=1, kind="stable")[:, :2]

    def _checked_samples(self, samples: ArrayLike, like_weights: bool = False) -> Floats:
        if np.ma.isMaskedArray(samples):
            raise MapError("samples are a masked array: leave out what is masked, or fill it in")
        data = np.ascontiguousarray(samples, dtype=np.float64)  # the same bits in any order of memory
        if data.ndim != 2 or 0 in data.shape:
            raise MapError(f"samples of shape {data.shape}: expected (n, dims) with at least one of each")
        if not (np.abs(data) < LARGEST).all():
            raise MapError(
                f"samples hold values that are not finite, or not below {LARGEST:g}: scale them first"
            )
        if like_weights and data.shape[1] != self.weights.shape[1]:
            raise MapError(f"samples of {data.shape[1]} dimensions for a SOM of {self.weights.shape[1]}")
        return data

    def _checked_weights(self, weights: ArrayLike) -> NDArray[np.floating]:
        table = np.array(weights)
        if table.dtype not in (np.float32, np.float64):
            table = table.astype(np.float64)
        if table.ndim != 2 or table.shape[0] != self.units or table.shape[1] < 1:
            raise MapError(f"weights of shape {table.shape}: expected ({self.units}, dims)")
        if not np.isfinite(table).all():
            raise MapError("weights hold values that are not finite")
        return frozen(np.ascontiguousarray(table))
