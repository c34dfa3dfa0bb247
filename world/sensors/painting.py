"""Images by rays, supersampled, with lit and textured faces, a checked floor and a sky."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ..errors import WorldError
from ..geometry import Floats
from ..robot import Image
from .rays import Caster
from .scene import Faces, Ints

if TYPE_CHECKING:
    from ..spec import Color, WorldSpec

SUPERSAMPLING = 4
"""Rays per pixel along each side."""
MAX_WIDTH, MAX_HEIGHT = 640, 480
_BAND = 1 << 18
"""Most rays that are cast at once, which bounds the memory of a large image."""
_LUMA = np.array((0.2126, 0.7152, 0.0722))
Place: TypeAlias = tuple[float, float, float, float]
"""x, y, height (m) and heading (rad) of a camera."""


@dataclass(frozen=True, slots=True)
class Paint:
    """How the faces of a scene look. shades: (faces, ...) tones; texture: (faces,) index or -1.

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


class Painter:
    """Renders images of scenes: in luminance, or in color.

    What follows is in tones: one number, luminance (by the weights of Rec. 709), or three: red, green, blue.
    """

    def __init__(self, spec: WorldSpec, color: bool = False, samples: int = SUPERSAMPLING) -> None:
        """Prepares light and textures; `samples`: rays per pixel along each side."""
        scenery = spec.scenery
        self._tones: tuple[int, ...] = (3,) if color else ()
        self._ambient, self._check, self._samples = scenery.ambient, scenery.floor_check, samples
        self._names = [texture.name for texture in spec.textures]
        self._bitmaps = tuple(np.array(texture.rows) for texture in spec.textures)
        light = np.array(scenery.light)
        self._light: Floats = light / np.linalg.norm(light)
        self._sky = self._toned([scenery.sky])[0]
        self._floor = self._toned([scenery.floor, scenery.floor_alternate])
        self._floor *= self.lit(np.array(((0.0, 0.0, 1.0),)))[0]

    def _toned(self, colors: Sequence[Color]) -> Floats:
        """Tones (colors, ...) of colors."""
        if self._tones:
            return np.array(colors, dtype=np.float64).reshape(-1, 3)
        return np.array([float(_LUMA @ np.array(color)) for color in colors], dtype=np.float64)

    def lit(self, normals: Floats) -> Floats:
        """How much of their color faces with these unit normals (n, 3) show: 0..1.

        Half-Lambert: a face turned away still differs from its neighbors, as under a wide lamp.
        """
        return self._ambient + (1.0 - self._ambient) * (0.5 + 0.5 * (normals @ self._light))

    def paint(self, faces: Faces) -> Paint:
        """The look of every face under this light."""
        surfaces = [shape.surface for shape in faces.shapes]
        names = [self._names.index(look.texture) if look.texture else -1 for look in surfaces]
        along = faces.segments[:, 2:] - faces.segments[:, :2]
        length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)
        sides = len(faces.segments)
        texture = np.full(faces.count, -1, dtype=np.int64)
        starts, directions = np.zeros((faces.count, 2)), np.zeros((faces.count, 2))
        tiles = np.ones((faces.count, 2))
        if sides:
            texture[:sides] = np.array(names)[faces.owners]
            starts[:sides], directions[:sides] = faces.segments[:, :2], along / length[:, None]
            tiles[:sides] = np.array([look.tile for look in surfaces])[faces.owners]
        own = faces.of_shapes(self._toned([look.color for look in surfaces]))
        shades = own * _alike(self.lit(faces.normals()), own)
        return Paint(shades, texture, starts, directions, tiles, self._bitmaps)

    def _render(self, place: Place, rays: Image, layers: Sequence[Layer]) -> Floats:
        """Tones (n, ...) along rays (n, 3), given in the camera's frame."""
        cosine, sine = math.cos(place[3]), math.sin(place[3])
        turn = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)), dtype=np.float32)
        directions = rays @ turn
        origin = np.array(place[:3])
        origins = np.empty_like(directions)
        origins[:] = origin
        shades = np.empty((len(directions), *self._tones))
        nearest = np.full(len(directions), np.inf)
        missed = np.ones(len(directions), dtype=bool)
        for layer in layers:
            distances, face = layer.caster.cast(origins, directions)
            hit = np.flatnonzero(distances < nearest)
            missed[hit] = False
            nearest[hit] = distances[hit]
            shades[hit] = _shades(layer.paint, face[hit], origin, directions[hit], distances[hit])
        rest = np.flatnonzero(missed)
        shades[rest] = self._background(origin, directions[rest])
        return shades

    def image(self, place: Place, size: tuple[int, int], view: float, layers: Sequence[Layer]) -> Image:
        """One image (height, width, ...), tones in [0, 1]. size: (width, height); view: horizontal, rad.

        place: x, y, height (m) and heading (rad) of the camera.

        Raises: WorldError for a size outside 1x1..640x480.
        """
        width, height = size
        check_size(width, height)
        samples = self._samples
        rays = pixel_rays(width, height, view, samples)
        band = max(1, _BAND // (width * samples**2)) * width * samples**2
        parts = [self._render(place, rays[k : k + band], layers) for k in range(0, len(rays), band)]
        shades = parts[0] if len(parts) == 1 else np.concatenate(parts)
        result: Image = (
            shades.reshape(height, samples, width, samples, *self._tones).mean(axis=(1, 3)).astype(np.float32)
        )
        return result

    def _background(self, origin: Floats, directions: Image) -> Floats:
        """Sky above the horizon, the checked floor below: tones (n, ...)."""
        shades = np.empty((len(directions), *self._tones))
        shades[:] = self._sky
        down = np.flatnonzero(directions[:, 2] < 0)
        distance = -origin[2] / directions[down, 2]
        cells = np.floor((origin[0] + distance * directions[down, 0]) / self._check)
        cells += np.floor((origin[1] + distance * directions[down, 1]) / self._check)
        shades[down] = self._floor[(cells % 2).astype(np.intp)]
        return shades


def _shades(paint: Paint, face: Ints, origin: Floats, directions: Image, distances: Floats) -> Floats:
    """Tones (n, ...) at the points where rays hit faces."""
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
            shades[rows] *= _alike(bitmap[bitmap.shape[0] - 1 - up, across], shades)
    return shades


def _alike(values: Floats, tones: Floats) -> Floats:
    """Values (n,) in a shape in which they multiply tones (n, ...)."""
    return values.reshape(-1, *[1] * (tones.ndim - 1))


def check_size(width: int, height: int) -> None:
    """Refuses image sizes that the camera does not have.

    Raises: WorldError outside 1x1..640x480.
    """
    if not (1 <= width <= MAX_WIDTH and 1 <= height <= MAX_HEIGHT):
        raise WorldError(f"image size {width}x{height} is outside 1x1 to {MAX_WIDTH}x{MAX_HEIGHT}")
