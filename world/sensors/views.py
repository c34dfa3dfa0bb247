"""Camera images of a whole world: the fixed scene built once, the moving bodies when they have moved."""

from __future__ import annotations

from collections.abc import Sequence

from ..robot import Image, Pose, RobotGeometry
from ..spec import WorldSpec
from .camera import Camera, Layer
from .dynamic_obstacles import Moving
from .rays import make_caster
from .scene import Faces


class Views:
    """Renders for all robots of one world."""

    def __init__(self, geometry: RobotGeometry, spec: WorldSpec, moving: Moving, rays: str) -> None:
        """Prepares the camera; the scene is built for the first image."""
        self._camera = Camera(geometry, spec.scenery, spec.textures)
        self._spec = spec
        self._moving = moving
        self._rays = rays
        self._fixed: Layer | None = None
        self._moved: Layer | None = None
        self._moved_for: tuple[object, ...] = ()

    def render(
        self,
        own: int,
        pose: Pose,
        robots: Sequence[Pose],
        boxes: Sequence[Pose],
        width: int,
        height: int,
    ) -> Image:
        """What robot `own` sees from `pose`: (height, width), luminance in [0, 1]."""
        if self._fixed is None:
            self._fixed = self._layer(Faces(self._spec.shapes))
        layers = [self._fixed]
        if self._moving.count > 1:
            layers.append(self._moving_layer(own, robots, boxes))
        return self._camera.render(pose, width, height, layers)

    def _layer(self, faces: Faces) -> Layer:
        return Layer(make_caster(faces, self._rays), self._camera.paint(faces))

    def _moving_layer(self, own: int, robots: Sequence[Pose], boxes: Sequence[Pose]) -> Layer:
        key = (own, tuple(robots), tuple(boxes))
        if self._moved is None or key != self._moved_for:
            self._moved = self._layer(Faces(*self._moving.bodies(own, robots, boxes)))
            self._moved_for = key
        return self._moved
