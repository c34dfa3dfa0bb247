"""The camera: images by rays, supersampled, with lit faces, a checked floor and a sky."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from .base import WorldError
from .geometry import Floats
from .rays import Caster
from .robot import Image, Pose, RobotGeometry
from .scene import Faces, luminance
from .spec import Scenery

SUPERSAMPLING = 4
"""Rays per pixel along each side."""
MAX_WIDTH, MAX_HEIGHT = 640, 480


@lru_cache(maxsize=16)
def pixel_rays(width: int, height: int, field_of_view: float, samples: int) -> Floats:
    """Directions (height*samples * width*samples, 3) in the camera's frame: x ahead, y left, z up; x is 1.

    field_of_view: horizontal, rad; pixels are square.
    """
    half = math.tan(field_of_view / 2)
    columns, rows = width * samples, height * samples
    left = half * (1 - (2 * np.arange(columns) + 1) / columns)
    up = half * (rows - 2 * np.arange(rows) - 1) / columns
    directions = np.empty((rows, columns, 3))
    directions[..., 0], directions[..., 1], directions[..., 2] = 1.0, left, up[:, None]
    flat = directions.reshape(-1, 3)
    flat.setflags(write=False)
    return flat


class Camera:
    """Renders what a robot's camera sees of one set of faces."""

    def __init__(self, geometry: RobotGeometry, scenery: Scenery, samples: int = SUPERSAMPLING) -> None:
        """Prepares the light; `samples`: rays per pixel along each side."""
        self._geometry = geometry
        self._scenery = scenery
        self._samples = samples
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

    def brightness(self, faces: Faces) -> Floats:
        """Luminance (count,) of each face under the light."""
        shades: Floats = faces.albedo() * self.lit(faces.normals())
        return shades

    def render(self, pose: Pose, width: int, height: int, caster: Caster, brightness: Floats) -> Image:
        """One image (height, width), luminance in [0, 1].

        Raises: WorldError for a size outside 1x1..640x480.
        """
        check_size(width, height)
        local = pixel_rays(width, height, self._geometry.camera_field_of_view, self._samples)
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        directions = local @ np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        forward = self._geometry.camera_forward
        origin = np.array((pose.x + cosine * forward, pose.y + sine * forward, self._geometry.camera_height))
        _, face = caster.cast(np.broadcast_to(origin, directions.shape), directions)
        shades = self._background(origin, directions)
        hit = face >= 0
        shades[hit] = brightness[face[hit]]
        samples = self._samples
        image = shades.reshape(height, samples, width, samples).mean(axis=(1, 3))
        result: Image = image.astype(np.float32)
        return result

    def _background(self, origin: Floats, directions: Floats) -> Floats:
        """Sky above the horizon, the checked floor below: (n,) luminances."""
        shades = np.full(len(directions), self._sky)
        down = np.flatnonzero(directions[:, 2] < 0)
        distance = -origin[2] / directions[down, 2]
        side = self._scenery.floor_check
        cells = np.floor((origin[0] + distance * directions[down, 0]) / side)
        cells += np.floor((origin[1] + distance * directions[down, 1]) / side)
        shades[down] = self._floor[(cells % 2).astype(np.intp)]
        return shades


def check_size(width: int, height: int) -> None:
    """Refuses image sizes that the camera does not have.

    Raises: WorldError outside 1x1..640x480.
    """
    if not (1 <= width <= MAX_WIDTH and 1 <= height <= MAX_HEIGHT):
        raise WorldError(f"image size {width}x{height} is outside 1x1 to {MAX_WIDTH}x{MAX_HEIGHT}")
