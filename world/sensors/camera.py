"""The camera: images by rays, supersampled, with lit and textured faces, a checked floor and a sky."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import WorldError
from ..geometry import Floats
from ..robot import Image, Pose, RobotGeometry
from ..spec import Scenery, Texture
from .rays import Caster
from .scene import Faces, Ints, luminance

SUPERSAMPLING = 4
"""Rays per pixel along each side."""
MAX_WIDTH, MAX_HEIGHT = 640, 480
_BAND = 1 << 18
"""Most rays that are cast at once, which bounds the memory of a large image."""


@dataclass(frozen=True, slots=True)
class Paint:
    """How the faces of a scene look. shades: (faces,) luminance; texture: (faces,) index or -1.

    starts: (faces, 2) m where the texture begins; along: (faces, 2) unit vectors; tiles: (faces, 2) m.
    """

    shades: Floats
    texture: Ints
    starts: Floats
    along: Floats
    tiles: Floats
    bitmaps: tuple[Floats, ...]


@dataclass(frozen=True, slots=True)
class Layer:
    """Faces that can be hit, and how they look."""

    caster: Caster
    paint: Paint


@lru_cache(maxsize=16)
def pixel_rays(width: int, height: int, field_of_view: float, samples: int) -> Image:
    """Directions (height*samples * width*samples, 3) in the camera's frame: x ahead, y left, z up; x is 1.

    field_of_view: horizontal, rad; pixels are square.
    """
    half = math.tan(field_of_view / 2)
    columns, rows = width * samples, height * samples
    left = half * (1 - (2 * np.arange(columns) + 1) / columns)
    up = half * (rows - 2 * np.arange(rows) - 1) / columns
    directions = np.empty((rows, columns, 3), dtype=np.float32)
    directions[..., 0], directions[..., 1], directions[..., 2] = 1.0, left, up[:, None]
    flat = directions.reshape(-1, 3)
    flat.setflags(write=False)
    return flat


class Camera:
    """Renders what a robot's camera sees of layers of faces."""

    def __init__(
        self,
        geometry: RobotGeometry,
        scenery: Scenery,
        textures: Sequence[Texture] = (),
        samples: int = SUPERSAMPLING,
    ) -> None:
        """Prepares light and textures; `samples`: rays per pixel along each side."""
        self._geometry = geometry
        self._scenery = scenery
        self._samples = samples
        self._names = [texture.name for texture in textures]
        self._bitmaps = tuple(np.array(texture.rows) for texture in textures)
        light = np.array(scenery.light)
        self._light: Floats = light / np.linalg.norm(light)
        self._sky = luminance(scenery.sky)
        self._floor = np.array((luminance(scenery.floor), luminance(scenery.floor_alternate)))
        self._floor *= self.lit(np.array(((0.0, 0.0, 1.0),)))[0]

    def lit(self, normals: Floats) -> Floats:
        """How much of their color faces with these unit normals (n, 3) show: 0..1.

        Half-Lambert: a face turned away still differs from its neighbors, as under a wide lamp.
        """
        ambient = self._scenery.ambient
        return ambient + (1.0 - ambient) * (0.5 + 0.5 * (normals @ self._light))

    def paint(self, faces: Faces) -> Paint:
        """The look of every face under this light."""
        surfaces = [shape.surface for shape in faces.shapes]
        names = [self._names.index(look.texture) if look.texture else -1 for look in surfaces]
        along = faces.segments[:, 2:] - faces.segments[:, :2]
        length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)
        sides = len(faces.segments)
        texture = np.full(faces.count, -1, dtype=np.int64)
        starts, directions, tiles = (
            np.zeros((faces.count, 2)),
            np.zeros((faces.count, 2)),
            np.ones((faces.count, 2)),
        )
        if sides:
            texture[:sides] = np.array(names)[faces.owners]
            starts[:sides], directions[:sides] = faces.segments[:, :2], along / length[:, None]
            tiles[:sides] = np.array([look.tile for look in surfaces])[faces.owners]
        return Paint(
            faces.albedo() * self.lit(faces.normals()), texture, starts, directions, tiles, self._bitmaps
        )

    def render(self, pose: Pose, width: int, height: int, layers: Sequence[Layer]) -> Image:
        """One image (height, width), luminance in [0, 1].

        Raises: WorldError for a size outside 1x1..640x480.
        """
        check_size(width, height)
        samples = self._samples
        rays = pixel_rays(width, height, self._geometry.camera_field_of_view, samples)
        band = max(1, _BAND // (width * samples**2)) * width * samples**2
        shades = [self._shades(pose, rays[k : k + band], layers) for k in range(0, len(rays), band)]
        image = (
            (shades[0] if len(shades) == 1 else np.concatenate(shades))
            .reshape(height, samples, width, samples)
            .mean(axis=(1, 3))
        )
        result: Image = image.astype(np.float32)
        return result

    def _shades(self, pose: Pose, local: Image, layers: Sequence[Layer]) -> Floats:
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        turn = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)), dtype=np.float32)
        directions = local @ turn
        forward = self._geometry.camera_forward
        origin = np.array((pose.x + cosine * forward, pose.y + sine * forward, self._geometry.camera_height))
        origins = np.empty_like(directions)
        origins[:] = origin
        shades = np.empty(len(directions))
        nearest, face = layers[0].caster.cast(origins, directions)
        missed = face < 0
        hit = np.flatnonzero(~missed)
        shades[hit] = _colors(layers[0].paint, face[hit], origin, directions[hit], nearest[hit])
        for layer in layers[1:]:
            distances, face = layer.caster.cast(origins, directions)
            hit = np.flatnonzero(distances < nearest)
            missed[hit] = False
            nearest[hit] = distances[hit]
            shades[hit] = _colors(layer.paint, face[hit], origin, directions[hit], distances[hit])
        rest = np.flatnonzero(missed)
        shades[rest] = self._background(origin, directions[rest])
        return shades

    def _background(self, origin: Floats, directions: Image) -> Floats:
        """Sky above the horizon, the checked floor below: (n,) luminances."""
        shades = np.full(len(directions), self._sky)
        down = np.flatnonzero(directions[:, 2] < 0)
        distance = -origin[2] / directions[down, 2]
        side = self._scenery.floor_check
        cells = np.floor((origin[0] + distance * directions[down, 0]) / side)
        cells += np.floor((origin[1] + distance * directions[down, 1]) / side)
        shades[down] = self._floor[(cells % 2).astype(np.intp)]
        return shades


def _colors(paint: Paint, face: Ints, origin: Floats, directions: Image, distances: Floats) -> Floats:
    """Luminances (n,) at the points where rays hit faces."""
    shades: Floats = paint.shades[face]
    textures = paint.texture[face] if paint.bitmaps else face
    for index, bitmap in enumerate(paint.bitmaps):
        rows = np.flatnonzero(textures == index)
        if len(rows):
            which = face[rows]
            points = origin + distances[rows, None] * directions[rows]
            along = ((points[:, :2] - paint.starts[which]) * paint.along[which]).sum(axis=1)
            across = (
                np.floor(along / paint.tiles[which, 0] * bitmap.shape[1]).astype(np.intp) % bitmap.shape[1]
            )
            up = (
                np.floor(points[:, 2] / paint.tiles[which, 1] * bitmap.shape[0]).astype(np.intp)
                % bitmap.shape[0]
            )
            shades[rows] *= bitmap[bitmap.shape[0] - 1 - up, across]
    return shades


def check_size(width: int, height: int) -> None:
    """Refuses image sizes that the camera does not have.

    Raises: WorldError outside 1x1..640x480.
    """
    if not (1 <= width <= MAX_WIDTH and 1 <= height <= MAX_HEIGHT):
        raise WorldError(f"image size {width}x{height} is outside 1x1 to {MAX_WIDTH}x{MAX_HEIGHT}")
