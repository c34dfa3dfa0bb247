"""What a local map holds, as plain data: the form in which it is stored and exported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import MapError, some

if TYPE_CHECKING:
    from ..som.lattice import Floats, Ints
    from ..som.som import SOM, Method

PANORAMA_SHAPE = (4, 16, 16)
"""Views ahead, left, behind, right of the entry heading, each (16, 16) luminance in [0, 1]."""


@dataclass(frozen=True, slots=True)
class LocalMapContent:
    """All that a local map holds, as it is stored. Arrays are read-only; `LocalMap` says what they mean."""

    metric: SOM
    hits: Ints
    edges: Ints
    entry_heading: float
    perceptual: SOM | None = None
    view_positions: Floats | None = None
    view_error: float = 0.0
    entry_panorama: NDArray[np.float32] | None = None
    blocked: frozenset[tuple[int, int]] = frozenset()
    locating: Method = "best"

    def __post_init__(self) -> None:
        """Checks that the parts fit together. Raises: MapError."""
        units = self.metric.units
        if self.metric.weights.shape[1] != 2:
            raise MapError(
                f"a metric SOM of {self.metric.weights.shape[1]} dimensions: expected 2 (x, y in m)"
            )
        if self.hits.shape != (units,) or (self.hits < 0).any():
            raise MapError(f"hits of shape {self.hits.shape}: expected ({units},), none negative")
        if self.edges.ndim != 2 or self.edges.shape[1:] != (2,) or not _edges_fit(self.edges, units):
            raise MapError(f"free-space edges must be distinct pairs i < j of the {units} units")
        if (self.perceptual is None) != (self.view_positions is None):
            raise MapError("a perceptual SOM and its view positions come together or not at all")
        if self.perceptual is not None and self.view_positions is not None:
            expected = (self.perceptual.units, 2)
            if self.view_positions.shape != expected or np.isinf(self.view_positions).any():
                raise MapError(
                    f"view positions of shape {self.view_positions.shape}: expected {expected}, finite or NaN"
                )
        if self.entry_panorama is not None and self.entry_panorama.shape != PANORAMA_SHAPE:
            raise MapError(
                f"an entry panorama of shape {self.entry_panorama.shape}: expected {PANORAMA_SHAPE}"
            )
        if self.locating not in ("best", "nearest", "radial"):
            raise MapError(f"unknown way to locate {self.locating!r}; known: best, nearest, radial")
        kept = {(int(i), int(j)) for i, j in self.edges}
        if not self.blocked <= kept:
            raise MapError(f"blocked edges {some(sorted(self.blocked - kept))} are no free-space edges")


def _edges_fit(edges: Ints, units: int) -> bool:
    inside = bool(((edges >= 0) & (edges < units)).all()) and bool((edges[:, 0] < edges[:, 1]).all())
    return inside and len(np.unique(edges, axis=0)) == len(edges)
