"""What moves besides the sensing robot: other robots and movable boxes, as outlines where they are now."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..geometry import Edge, Plan, Point, disk, edges_of, outline_segments, rectangle
from ..robot import Pose, RobotGeometry
from ..spec import Cylinder, MovableBox, Polygon, Shape, Surface
from .infrared import InfraredModel

ROBOT_HEIGHT = 0.048
ROBOT_LOOK = Surface((0.2, 0.45, 0.25))
_FACETS = 24


class Moving:
    """Outlines and distances of all bodies that can move."""

    def __init__(self, geometry: RobotGeometry, movable: Sequence[MovableBox], robots: int) -> None:
        """Remembers sizes; poses are given with every question."""
        self.count = robots + len(movable)
        self._radius = geometry.body_radius
        self._movable = tuple(movable)
        self._reaches = [math.hypot(item.box.width, item.box.depth) / 2 for item in movable]

    def box_outline(self, index: int, pose: Pose) -> tuple[Point, ...]:
        """Corners (m) of a movable box at a pose."""
        box = self._movable[index].box
        return rectangle(pose.x, pose.y, box.width, box.depth, pose.heading)

    def bodies(
        self, own: int, robots: Sequence[Pose], boxes: Sequence[Pose]
    ) -> tuple[list[Shape], list[tuple[Point, ...]]]:
        """Shapes and outlines of everything that moves, but for robot `own`."""
        shapes: list[Shape] = []
        outlines: list[tuple[Point, ...]] = []
        for index, pose in enumerate(robots):
            if index != own:
                shapes.append(Cylinder(pose.x, pose.y, self._radius, ROBOT_HEIGHT, ROBOT_LOOK))
                outlines.append(disk(pose.x, pose.y, self._radius, _FACETS))
        for index, pose in enumerate(boxes):
            box = self._movable[index].box
            corners = self.box_outline(index, pose)
            shapes.append(Polygon(corners, box.height, box.surface))
            outlines.append(corners)
        return shapes, outlines

    def edges_near(
        self, own: int, pose: Pose, robots: Sequence[Pose], boxes: Sequence[Pose], infrared: InfraredModel
    ) -> list[Edge]:
        """The edges of moving bodies that infrared can reach from `pose`."""
        found = [
            disk(there.x, there.y, self._radius, _FACETS)
            for index, there in enumerate(robots)
            if index != own and pose.distance_to(there) < infrared.reach + self._radius
        ]
        found += [
            self.box_outline(index, there)
            for index, there in enumerate(boxes)
            if pose.distance_to(there) < infrared.reach + self._reaches[index]
            and self._movable[index].box.height >= infrared.height
        ]
        return edges_of(outline_segments(found)) if found else []

    def gaps(
        self, x: float, y: float, reach: float, own: int, robots: Sequence[Pose], boxes: Sequence[Pose]
    ) -> list[tuple[float, float, float]]:
        """Moving bodies nearer than `reach` (m) to a point: (distance, nx, ny), n the unit vector away."""
        found = []
        for index, there in enumerate(robots):
            distance = math.hypot(x - there.x, y - there.y)
            if index != own and 0.0 < distance < reach + self._radius:
                found.append((distance - self._radius, (x - there.x) / distance, (y - there.y) / distance))
        return found + self.box_gaps(x, y, reach, boxes)

    def box_gaps(
        self, x: float, y: float, reach: float, boxes: Sequence[Pose]
    ) -> list[tuple[float, float, float]]:
        """Movable boxes nearer than `reach` (m) to a point, as in `gaps`; 0 m when it is inside one."""
        found: list[tuple[float, float, float]] = []
        for index, there in enumerate(boxes):
            if math.hypot(x - there.x, y - there.y) < reach + self._reaches[index]:
                plan = Plan([Polygon(self.box_outline(index, there))])
                inside = plan.contains(x, y)
                found += [(0.0, 0.0, 0.0)] if inside else plan.gaps(x, y, reach)
        return found
