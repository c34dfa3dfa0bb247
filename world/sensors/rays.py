"""Rays against faces: Embree where it is installed, numpy everywhere; both give the same distances."""

from __future__ import annotations

import importlib
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import EngineMissingError
from ..geometry import Floats

if TYPE_CHECKING:
    from .scene import Faces, Ints

Rays: TypeAlias = NDArray[np.float64] | NDArray[np.float32]
"""(n, 3) m."""
FAR = 1e6
"""Distance (m) that stands for 'nothing hit' where an engine wants a finite one."""


class Caster(Protocol):
    """Finds what rays hit first among the faces it was built from."""

    def cast(self, origins: Rays, directions: Rays) -> tuple[Floats, Ints]:
        """Distances (n,) in units of the directions' lengths (inf: none) and faces (n,) hit (-1: none).

        origins, directions: (n, 3) m, world frame.
        """


class NumpyCaster:
    """Tests every ray against every face, in slices that keep memory small."""

    SLICE = 400_000

    def __init__(self, faces: Faces) -> None:
        """Takes the faces over."""
        self._faces = faces

    def cast(self, origins: Rays, directions: Rays) -> tuple[Floats, Ints]:
        """See `Caster.cast`."""
        count = max(1, len(self._faces.segments))
        step = max(1, self.SLICE // count)
        parts = [
            self._cast(origins[k : k + step], directions[k : k + step]) for k in range(0, len(origins), step)
        ]
        if not parts:
            return np.zeros(0), np.zeros(0, dtype=np.int64)
        return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])

    def _cast(self, origins: Rays, directions: Rays) -> tuple[Floats, Ints]:
        best, face = self._sides(origins, directions)
        for index, points in enumerate(self._faces.outlines):
            height = self._faces.tops[index]
            above = (origins[:, 2] > height) & (directions[:, 2] < 0)
            if above.any():
                self._top(index, points, height, origins, directions, above, best, face)
        return best, face

    def _sides(self, origins: Rays, directions: Rays) -> tuple[Floats, Ints]:
        segments = self._faces.segments
        if not len(segments):
            return np.full(len(origins), np.inf), np.full(len(origins), -1, dtype=np.int64)
        along_x, along_y = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
        ray_x, ray_y, ray_z = directions[:, :1], directions[:, 1:2], directions[:, 2:]
        off_x, off_y = segments[:, 0] - origins[:, :1], segments[:, 1] - origins[:, 1:2]
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / (ray_x * along_y - ray_y * along_x)
            distance = (off_x * along_y - off_y * along_x) * inverse
            share = (off_x * ray_y - off_y * ray_x) * inverse
            height = origins[:, 2:] + distance * ray_z
            hit = (distance >= 0) & (share >= -1e-9) & (share <= 1 + 1e-9)
            hit &= (height >= 0) & (height <= self._faces.heights)
        distance = np.where(hit, distance, np.inf)
        face: Ints = np.argmin(distance, axis=1)
        best: Floats = distance[np.arange(len(origins)), face]
        return best, np.where(np.isfinite(best), face, -1)

    def _top(
        self,
        index: int,
        points: tuple[tuple[float, float], ...],
        height: float,
        origins: Rays,
        directions: Rays,
        above: NDArray[np.bool_],
        best: Floats,
        face: Ints,
    ) -> None:
        rows = np.flatnonzero(above)
        distance = (height - origins[rows, 2]) / directions[rows, 2]
        x = origins[rows, 0] + distance * directions[rows, 0]
        y = origins[rows, 1] + distance * directions[rows, 1]
        inside = np.zeros(len(rows), dtype=bool)
        for (x0, y0), (x1, y1) in zip(points, (*points[1:], points[0]), strict=True):
            if y0 != y1:
                inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        nearer = rows[inside & (distance < best[rows])]
        best[nearer] = ((height - origins[:, 2]) / np.where(above, directions[:, 2], 1.0))[nearer]
        face[nearer] = len(self._faces.segments) + index


class EmbreeCaster:
    """Embree, through embreex: one static scene, built once."""

    def __init__(self, faces: Faces) -> None:
        """Builds the scene. Raises: ImportError where embreex is not installed."""
        scenes = importlib.import_module("embreex.rtcore_scene")
        meshes = importlib.import_module("embreex.mesh_construction")
        triangles, face_of = faces.triangles()
        self._face_of: Ints = np.append(face_of, -1)
        self._scene: Any = scenes.EmbreeScene(_device())
        if len(triangles):
            self._mesh: Any = meshes.TriangleMesh(self._scene, np.ascontiguousarray(triangles))

    def cast(self, origins: Rays, directions: Rays) -> tuple[Floats, Ints]:
        """See `Caster.cast`; single precision."""
        if len(self._face_of) == 1 or not len(origins):
            return np.full(len(origins), np.inf), np.full(len(origins), -1, dtype=np.int64)
        limits = np.full(len(origins), FAR, dtype=np.float32)
        found = self._scene.run(
            np.ascontiguousarray(origins, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            dists=limits,
            query="INTERSECT",
            output=True,
        )
        triangle = found["primID"]
        # -1, a miss, picks the last entry of each table
        face: Ints = self._face_of[triangle]
        distances: Floats = found["tfar"].astype(np.float64)
        distances[triangle < 0] = np.inf
        return distances, face


@cache
def _device() -> Any:
    return importlib.import_module("embreex.rtcore").EmbreeDevice()


@cache
def embree_available() -> bool:
    """Whether embreex can be imported."""
    try:
        importlib.import_module("embreex.rtcore_scene")
    except ImportError:
        return False
    return True


def make_caster(faces: Faces, engine: str = "auto") -> Caster:
    """The caster for `engine`: "embree", "numpy", or "auto" for the first that is installed.

    Raises: EngineMissingError when Embree is asked for and not installed.
    """
    if engine == "embree" and not embree_available():
        raise EngineMissingError("the ray engine 'embree' needs embreex: pip install embreex; or use 'numpy'")
    if engine == "embree" or (engine == "auto" and embree_available()):
        return EmbreeCaster(faces)
    return NumpyCaster(faces)
