"""The lattice a SOM's units sit on: who neighbors whom, and how far apart."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import MapError

Topology = Literal["hexagonal", "rectangular"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Array = TypeVar("Array", bound=NDArray[Any])

MAX_UNITS = 10_000
"""A SOM larger than this is refused: its lattice tables grow with the square."""


SHARED_UNITS = 256
"""Tables of lattices of up to this many units are kept for the next SOM of that shape."""


@dataclass(frozen=True)
class Lattice:
    """`rows` x `cols` units, one row or column for a 1-d map; unit index = row * cols + col.

    hexagonal: odd rows are shifted half a unit to the right; six neighbors inside.
    rectangular: eight neighbors inside (diagonals count).
    """

    rows: int
    cols: int
    topology: Topology = "hexagonal"

    def __post_init__(self) -> None:
        """Checks sizes and name. Raises: MapError."""
        if self.topology not in ("hexagonal", "rectangular"):
            raise MapError(f"unknown topology {self.topology!r}; known: hexagonal, rectangular")
        if self.rows < 1 or self.cols < 1 or self.rows * self.cols > MAX_UNITS:
            raise MapError(
                f"a lattice of {self.rows} x {self.cols} units: sizes from 1, at most {MAX_UNITS} units"
            )

    @property
    def units(self) -> int:
        """How many units there are."""
        return self.rows * self.cols

    @property
    def shared(self) -> bool:
        """Whether it is so small that its tables are kept for the next SOM of its shape."""
        return self.units <= SHARED_UNITS

    @cached_property
    def positions(self) -> Floats:
        """(units, 2) x, y in lattice units; direct neighbors are 1 apart. Read-only."""
        row, col = np.divmod(np.arange(self.units), self.cols)
        x, y = col.astype(np.float64), row.astype(np.float64)
        if self.topology == "hexagonal":
            x, y = x + 0.5 * (row % 2), y * (math.sqrt(3.0) / 2.0)
        return frozen(np.column_stack([x, y]))

    @cached_property
    def squared_distances(self) -> Floats:
        """(units, units) squared lattice distance, ||r_c - r_p||^2 of eq. 3.22. Read-only."""
        difference = self.positions[:, None, :] - self.positions[None, :, :]
        return frozen(np.einsum("ijk,ijk->ij", difference, difference))

    @cached_property
    def steps(self) -> Ints:
        """(units, units) fewest lattice edges between two units. Read-only."""
        row, col = np.divmod(np.arange(self.units), self.cols)
        if self.topology == "rectangular":
            apart = np.maximum(np.abs(row[:, None] - row), np.abs(col[:, None] - col))
        else:
            axial = col - (row - row % 2) // 2
            q, r = axial[:, None] - axial, row[:, None] - row
            apart = (np.abs(q) + np.abs(r) + np.abs(q + r)) // 2
        return frozen(apart.astype(np.int64))

    @cached_property
    def adjacency(self) -> NDArray[np.bool_]:
        """(units, units) whether two units are direct neighbors. Read-only."""
        return frozen(self.steps == 1)

    def neighbors(self, unit: int) -> tuple[int, ...]:
        """The direct neighbors of a unit, in increasing order."""
        return tuple(int(i) for i in np.flatnonzero(self.adjacency[unit]))

    def torn(self, apart: Floats) -> NDArray[np.bool_]:
        """Whether best and second-best unit are no neighbors, for distances (..., units)."""
        if self.units < 2:
            return np.zeros(apart.shape[:-1], dtype=bool)
        rows = apart.reshape(-1, self.units).copy()
        each = np.arange(len(rows))
        first = rows.argmin(axis=1)
        rows[each, first] = np.inf
        return np.asarray(~self.adjacency[first, rows.argmin(axis=1)].reshape(apart.shape[:-1]))

    @cached_property
    def edges(self) -> Ints:
        """(edges, 2) pairs of neighboring units, smaller index first, sorted. Read-only."""
        return frozen(np.argwhere(np.triu(self.adjacency)).astype(np.int64))


def lattice_of(rows: int, cols: int, topology: Topology = "hexagonal") -> Lattice:
    """The lattice of that shape; SOMs of the same, not too large shape share its tables. Raises: MapError."""
    return _shared(rows, cols, topology) if rows * cols <= SHARED_UNITS else Lattice(rows, cols, topology)


@lru_cache(maxsize=32)
def _shared(rows: int, cols: int, topology: Topology) -> Lattice:
    return Lattice(rows, cols, topology)


def frozen(array: Array) -> Array:
    """The same array, made read-only."""
    array.flags.writeable = False
    return array
