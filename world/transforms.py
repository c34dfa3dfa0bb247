"""Worlds made from worlds: mirrored, turned, scaled, and with other surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from .errors import WorldError
from .geometry import Plan, Point
from .robot import Pose, wrap_angle
from .spec import Box, Cylinder, Polygon, Shape, Start, Surface, WorldSpec

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


def rotated(spec: WorldSpec, angle: float) -> WorldSpec:
    """The world turned by `angle` (rad, counter-clockwise) around the middle of its bounds.

    The lamp and the floor's pattern stay where they are, as for a room built again under the same sky: what
    a camera sees changes, what touches and distances tell does not.
    """
    if angle == 0.0:
        return spec
    x0, y0, x1, y1 = Plan(spec.shapes).bounds
    turn = _Turn(angle, 0.5 * (x0 + x1), 0.5 * (y0 + y1))
    return replace(
        spec,
        shapes=tuple(turn.shape(shape) for shape in spec.shapes),
        starts=tuple(replace(start, pose=turn.pose(start.pose)) for start in spec.starts),
        robots=tuple(turn.pose(pose) for pose in spec.robots),
        movable=tuple(replace(movable, box=turn.box(movable.box)) for movable in spec.movable),
    )


@dataclass(frozen=True, slots=True)
class _Turn:
    """A turn by `angle` (rad) around (x, y) (m)."""

    angle: float
    x: float
    y: float

    def point(self, point: Point) -> Point:
        dx, dy = point[0] - self.x, point[1] - self.y
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return self.x + cosine * dx - sine * dy, self.y + sine * dx + cosine * dy

    def pose(self, pose: Pose) -> Pose:
        return Pose(*self.point((pose.x, pose.y)), wrap_angle(pose.heading + self.angle))

    def box(self, box: Box) -> Box:
        x, y = self.point((box.x, box.y))
        return replace(box, x=x, y=y, angle=box.angle + self.angle)

    def shape(self, shape: Shape) -> Shape:
        if isinstance(shape, Box):
            return self.box(shape)
        if isinstance(shape, Cylinder):
            x, y = self.point((shape.x, shape.y))
            return replace(shape, x=x, y=y)
        if isinstance(shape, Polygon):
            return replace(shape, points=tuple(self.point(point) for point in shape.points))
        return replace(shape, start=self.point(shape.start), end=self.point(shape.end))


def scaled(spec: WorldSpec, factor: float) -> WorldSpec:
    """The world `factor` times as wide and deep; heights stay, and so does what robots are.

    Raises: WorldError unless the factor is within 0.001..1000.
    """
    if not 1e-3 <= factor <= 1e3:
        raise WorldError(f"scale {factor:g} is outside 0.001 to 1000")
    if factor == 1.0:
        return spec
    return replace(
        spec,
        shapes=tuple(_scale_shape(shape, factor) for shape in spec.shapes),
        starts=tuple(replace(start, pose=_scale_pose(start.pose, factor)) for start in spec.starts),
        robots=tuple(_scale_pose(pose, factor) for pose in spec.robots),
        movable=tuple(replace(movable, box=_scale_box(movable.box, factor)) for movable in spec.movable),
    )


def _scale_pose(pose: Pose, factor: float) -> Pose:
    return Pose(pose.x * factor, pose.y * factor, pose.heading)


def _scale_box(box: Box, factor: float) -> Box:
    return replace(
        box, x=box.x * factor, y=box.y * factor, width=box.width * factor, depth=box.depth * factor
    )


def _scale_shape(shape: Shape, factor: float) -> Shape:
    if isinstance(shape, Box):
        return _scale_box(shape, factor)
    if isinstance(shape, Cylinder):
        return replace(shape, x=shape.x * factor, y=shape.y * factor, radius=shape.radius * factor)
    if isinstance(shape, Polygon):
        return replace(shape, points=tuple((x * factor, y * factor) for x, y in shape.points))
    (x0, y0), (x1, y1) = shape.start, shape.end
    ends = (x0 * factor, y0 * factor), (x1 * factor, y1 * factor)
    return replace(shape, start=ends[0], end=ends[1], thickness=shape.thickness * factor)


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
