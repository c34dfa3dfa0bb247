"""What a local map holds, as plain data: the form in which it is stored and exported."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MapError, some
from ..fields import MAX_ANGLE, MAX_METERS

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
        self._check_sizes()
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
            if self.view_positions.shape != expected:
                raise MapError(f"view positions of shape {self.view_positions.shape}: expected {expected}")
        if self.entry_panorama is not None and self.entry_panorama.shape != PANORAMA_SHAPE:
            raise MapError(
                f"an entry panorama of shape {self.entry_panorama.shape}: expected {PANORAMA_SHAPE}"
            )
        if self.locating not in ("best", "nearest", "radial"):
            raise MapError(f"unknown way to locate {self.locating!r}; known: best, nearest, radial")
        kept = set(map(tuple, self.edges.tolist()))
        if not self.blocked <= kept:
            raise MapError(f"blocked edges {some(sorted(self.blocked - kept))} are no free-space edges")

    def _check_sizes(self) -> None:
        """Refuses values that no local space or view has, and makes the arrays read-only."""
        limits: dict[str, tuple[Any, float]] = {
            "metric weights": (self.metric.weights, MAX_METERS),
            "hits": (self.hits, 2**31),
            "view positions": (self.view_positions, MAX_METERS),
            "perceptual weights": (None if self.perceptual is None else self.perceptual.weights, MAX_METERS),
            "entry panorama": (self.entry_panorama, MAX_METERS),
            "entry heading": (self.entry_heading, MAX_ANGLE),
            "view error": (self.view_error, MAX_METERS),
        }
        for name, (values, limit) in limits.items():
            if values is not None and (np.abs(values) > limit).any():
                raise MapError(f"{name}: at most {limit:g}")
        for array in (self.hits, self.edges, self.view_positions, self.entry_panorama):
            if array is not None:
                array.flags.writeable = False

    def __reduce__(self) -> tuple[type[LocalMapContent], tuple[Any, ...]]:
        """Pickled by its parts, so that whoever unpickles it checks them."""
        return LocalMapContent, tuple(getattr(self, each.name) for each in fields(self))


def _edges_fit(edges: Ints, units: int) -> bool:
    inside = bool(((edges >= 0) & (edges < units)).all()) and bool((edges[:, 0] < edges[:, 1]).all())
    return inside and len(np.unique(edges, axis=0)) == len(edges)
