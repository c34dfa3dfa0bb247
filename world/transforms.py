"""Worlds made from worlds: mirrored, and with other surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from .geometry import Plan
from .robot import Pose, wrap_angle
from .spec import Box, Cylinder, Point, Polygon, Shape, Start, Surface, WorldSpec

_OTHER_SIDE = {"right": "left", "left": "right"}


def resurfaced(spec: WorldSpec, surfaces: Sequence[Surface]) -> WorldSpec:
    """The same world, the surfaces laid on its shapes in turn."""
    shapes = tuple(replace(shape, surface=surfaces[k % len(surfaces)]) for k, shape in enumerate(spec.shapes))
    return replace(spec, shapes=shapes if surfaces else spec.shapes)


def mirrored(spec: WorldSpec) -> WorldSpec:
    """The world seen in a mirror that stands along y; the starts `right` and `left` change places."""
    x0, _, x1, _ = Plan(spec.shapes).bounds
    total = x0 + x1
    return replace(
        spec,
        shapes=tuple(_mirror_shape(shape, total) for shape in spec.shapes),
        starts=tuple(
            sorted(
                (
                    Start(_OTHER_SIDE.get(start.name, start.name), _mirror_pose(start.pose, total))
                    for start in spec.starts
                ),
                key=lambda start: start.name,
                reverse=True,
            )
        ),
        robots=tuple(_mirror_pose(pose, total) for pose in spec.robots),
        movable=tuple(replace(movable, box=_mirror_box(movable.box, total)) for movable in spec.movable),
    )


def _mirror_pose(pose: Pose, total: float) -> Pose:
    return Pose(total - pose.x, pose.y, wrap_angle(math.pi - pose.heading))


def _mirror_point(point: Point, total: float) -> Point:
    return total - point[0], point[1]


def _mirror_box(box: Box, total: float) -> Box:
    return replace(box, x=total - box.x, angle=-box.angle if box.angle else 0.0)


def _mirror_shape(shape: Shape, total: float) -> Shape:
    if isinstance(shape, Box):
        return _mirror_box(shape, total)
    if isinstance(shape, Cylinder):
        return replace(shape, x=total - shape.x)
    if isinstance(shape, Polygon):
        return replace(shape, points=tuple(_mirror_point(point, total) for point in reversed(shape.points)))
    return replace(shape, start=_mirror_point(shape.start, total), end=_mirror_point(shape.end, total))
