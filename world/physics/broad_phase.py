"""Which fixed shapes are near a body: only those are kept in the physics, as its cost is per shape."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry import Floats
from ..spec import Box, Cylinder

Place = tuple[float, float]


class BroadPhase:
    """Follows places (m) and says which shapes must be there for whatever happens around them."""

    SLACK = 0.02
    """How far (m) a body moves before the shapes around it are gathered again."""
    MARGIN = 0.02
    """m beyond the slack and the body's own size; a robot drives at most 4 mm in the tick in between."""

    def __init__(self, solids: Sequence[Box | Cylinder], size: float) -> None:
        """size: distance (m) of the outermost point of any body from its place."""
        self.solids = tuple(solids)
        boxes = [
            (solid.x, solid.y, solid.width / 2, solid.depth / 2, solid.angle)
            if isinstance(solid, Box)
            else (solid.x, solid.y, solid.radius, solid.radius, 0.0)
            for solid in solids
        ]
        x, y, width, depth, angle = np.array(boxes, dtype=np.float64).reshape(-1, 5).T
        self._centers: tuple[Floats, Floats] = x, y
        self._halves: tuple[Floats, Floats] = width, depth
        self._cosine: Floats = np.cos(angle)
        self._sine: Floats = np.sin(angle)
        self._reach = size + self.SLACK + self.MARGIN
        self.kept: tuple[int, ...] = ()
        self.anchors: list[Place] = []

    def follow(self, places: list[Place]) -> tuple[int, ...] | None:
        """As `gather`, if a body has moved away from where it was at the last time; else None."""
        limit = self.SLACK**2
        if len(places) == len(self.anchors):
            for (x, y), (x0, y0) in zip(places, self.anchors, strict=True):
                if (x - x0) ** 2 + (y - y0) ** 2 > limit:
                    break
            else:
                return None
        return self.gather(places)

    def gather(self, places: list[Place]) -> tuple[int, ...] | None:
        """The shapes near `places`, in the order of the description; None when they are those of before."""
        self.anchors = list(places)
        near = np.zeros(len(self.solids), dtype=bool)
        for place in places:
            near |= self._gaps(*place) < self._reach
        kept = tuple(np.flatnonzero(near).tolist())
        if kept == self.kept:
            return None
        self.kept = kept
        return kept

    def _gaps(self, x: float, y: float) -> Floats:
        """Distances (n,) m from a point to the shapes, 0 inside; a cylinder counts as its square."""
        east, north = x - self._centers[0], y - self._centers[1]
        along = np.abs(self._cosine * east + self._sine * north) - self._halves[0]
        across = np.abs(self._cosine * north - self._sine * east) - self._halves[1]
        gaps: Floats = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
        return gaps
