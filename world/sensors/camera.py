"""The camera: takes an image when it is asked for one, of any size, in luminance or in color."""

from __future__ import annotations

import math

import numpy as np

from ..robot import Image, Pose
from .painting import Layer, Painter, Place
from .sensor import Motion, Mounting, Sensor
from .surroundings import Scene


class Camera(Sensor):
    """Measures where it is; `look` gives the image from there. Noise: normal, alike in every pixel."""

    def __init__(self, mounting: Mounting) -> None:
        """The scene is painted for the first image."""
        self._mounting = mounting
        self._random = mounting.streams.generator("camera")
        self._pictures: dict[bool, _Picture] = {}

    def measure(self, motion: Motion) -> Pose:
        """Where an image would be taken from."""
        return motion.pose

    def look(self, pose: Pose, width: int, height: int, color: bool) -> Image:
        """The image from a pose: (height, width) luminance or (height, width, 3) RGB, in [0, 1].

        Raises: WorldError for a size outside 1x1..640x480.
        """
        geometry, noise = self._mounting.geometry, self._mounting.noise.camera
        if color not in self._pictures:
            self._pictures[color] = _Picture(self._mounting, color)
        forward = geometry.camera_forward
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        place = pose.x + cosine * forward, pose.y + sine * forward, geometry.camera_height, pose.heading
        image = self._pictures[color].taken(place, (width, height))
        if noise > 0.0:
            deviations = self._random.standard_normal(image.shape, dtype=np.float32)
            image = np.clip(image + np.float32(noise) * deviations, 0.0, 1.0, dtype=np.float32)
        return image


class _Picture:
    """The surroundings painted in luminance or in color: fixed shapes once, others when they moved."""

    def __init__(self, mounting: Mounting, color: bool) -> None:
        self._own, self._surroundings = mounting.own, mounting.surroundings
        self._view = mounting.geometry.camera_field_of_view
        self._painter = Painter(self._surroundings.spec, color)
        self._fixed = self._layer(self._surroundings.fixed)
        self._moving: tuple[Scene, Layer] | None = None

    def taken(self, place: Place, size: tuple[int, int]) -> Image:
        layers = [self._fixed]
        others = self._surroundings.others(self._own)
        if others is not None:
            if self._moving is None or self._moving[0] is not others:
                self._moving = others, self._layer(others)
            layers.append(self._moving[1])
        return self._painter.image(place, size, self._view, layers)

    def _layer(self, scene: Scene) -> Layer:
        return Layer(scene.caster, self._painter.paint(scene.faces))
