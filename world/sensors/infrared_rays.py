"""Infrared distances by the casters that the camera uses, not by plain Python on the edges in reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..robot import Pose
from ..spec import Shape
from .infrared import RECESS, InfraredModel
from .rays import make_caster
from .scene import Faces


class InfraredCaster:
    """The same distances as `InfraredModel.distances`, to fixed shapes, with Embree or with numpy."""

    def __init__(self, model: InfraredModel, shapes: Sequence[Shape], engine: str) -> None:
        """engine: as for `make_caster`."""
        self._model = model
        self._caster = make_caster(Faces(shapes), engine)
        self._height = model.height

    def distances(self, pose: Pose) -> list[float]:
        """Distances (m) from the rim, sensors * rays of them, at most the range. Embree: single precision."""
        origins, directions = self._model.world_rays(pose)
        count = len(origins)
        starts, ways = np.empty((count, 3)), np.zeros((count, 3))
        starts[:, :2], starts[:, 2] = origins - RECESS * directions, self._height
        ways[:, :2] = directions
        found, _ = self._caster.cast(starts, ways)
        limited: list[float] = np.minimum(found - RECESS, self._model.range).tolist()
        return limited
