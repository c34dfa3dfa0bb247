"""What is around a robot: the fixed shapes, and the bodies that move, where they are now.

The one place that sensors, contacts and placing ask. A simulated world owns one and keeps its poses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ..geometry import Edge, Floats, Plan, Point, disk, edges_of, outline_segments, rectangle
from ..robot import Pose, RobotGeometry
from ..spec import Cylinder, Polygon, Shape, Surface, WorldSpec
from .rays import Caster, Rays, make_caster
from .scene import Faces

ROBOT_HEIGHT = 0.048
ROBOT_LOOK = Surface((0.2, 0.45, 0.25))
_FACETS = 24


@dataclass(frozen=True, slots=True)
class Scene:
    """Faces, and what casts rays at them."""

    faces: Faces
    caster: Caster


class Surroundings:
    """All that robots can meet. robots, boxes: true poses of the robots and the movable boxes, world frame.

    rays: as for `make_caster`. Positions are in m, `own` is the index of the robot that asks.
    """

    def __init__(self, spec: WorldSpec, robots: Sequence[Pose], geometry: RobotGeometry, rays: str) -> None:
        """The boxes begin where the description says."""
        self.spec, self.rays = spec, rays
        self.robots = list(robots)
        self.boxes = [Pose(item.box.x, item.box.y, item.box.angle) for item in spec.movable]
        self.plan = Plan(spec.shapes)
        self.alone = len(self.robots) + len(self.boxes) == 1
        """Whether nothing moves but one robot."""
        self._radius = geometry.body_radius
        self._sizes = [item.box for item in spec.movable]
        self._reaches = [math.hypot(box.width, box.depth) / 2 for box in self._sizes]
        self._others: dict[int, tuple[object, Scene]] = {}

    def plan_above(self, height: float) -> Plan:
        """The plan of what is at least `height` (m) high: all of it, where all is."""
        if all(shape.height >= height for shape in self.spec.shapes):
            return self.plan
        return Plan(self.spec.shapes, min_height=height)

    @cached_property
    def fixed(self) -> Scene:
        """The fixed shapes; built when it is first asked for."""
        return self._scene(Faces(self.spec.shapes))

    def others(self, own: int) -> Scene | None:
        """Everything that moves, but for the robot that asks; built again when anything has moved."""
        if self.alone:
            return None
        places = tuple(self.robots), tuple(self.boxes)
        if own not in self._others or self._others[own][0] != places:
            self._others[own] = places, self._scene(self._faces(own))
        return self._others[own][1]

    def distances(self, own: int, origins: Rays, directions: Rays) -> Floats:
        """Distances (n,) along rays to whatever is met first, in units of their directions; inf: nothing.

        origins, directions: (n, 3) m, world frame. The floor is not met.
        """
        nearest, _ = self.fixed.caster.cast(origins, directions)
        others = self.others(own)
        if others is not None:
            nearest = nearest.clip(max=others.caster.cast(origins, directions)[0])
        return nearest

    def _scene(self, faces: Faces) -> Scene:
        return Scene(faces, make_caster(faces, self.rays))

    def _faces(self, own: int) -> Faces:
        shapes: list[Shape] = []
        outlines: list[tuple[Point, ...]] = []
        for index, pose in enumerate(self.robots):
            if index != own:
                shapes.append(Cylinder(pose.x, pose.y, self._radius, ROBOT_HEIGHT, ROBOT_LOOK))
                outlines.append(disk(pose.x, pose.y, self._radius, _FACETS))
        for index, box in enumerate(self._sizes):
            corners = self._box_outline(index)
            shapes.append(Polygon(corners, box.height, box.surface))
            outlines.append(corners)
        return Faces(shapes, outlines)

    def _box_outline(self, index: int) -> tuple[Point, ...]:
        box, pose = self._sizes[index], self.boxes[index]
        return rectangle(pose.x, pose.y, box.width, box.depth, pose.heading)

    def moving_edges(self, own: int, pose: Pose, reach: float, height: float) -> list[Edge]:
        """The edges of moving bodies at least `height` (m) high that may be within `reach` (m) of a pose."""
        found = [
            disk(there.x, there.y, self._radius, _FACETS)
            for index, there in enumerate(self.robots)
            if index != own and pose.distance_to(there) < reach + self._radius
        ]
        found += [
            self._box_outline(index)
            for index, there in enumerate(self.boxes)
            if pose.distance_to(there) < reach + self._reaches[index] and self._sizes[index].height >= height
        ]
        return edges_of(outline_segments(found)) if found else []

    def moving_gaps(self, own: int, x: float, y: float, reach: float) -> list[tuple[float, float, float]]:
        """Moving bodies nearer than `reach` (m) to a point: (distance, nx, ny), n the unit vector away."""
        found = []
        for index, there in enumerate(self.robots):
            distance = math.hypot(x - there.x, y - there.y)
            if index != own and 0.0 < distance < reach + self._radius:
                found.append((distance - self._radius, (x - there.x) / distance, (y - there.y) / distance))
        return found + self.box_gaps(x, y, reach)

    def box_gaps(self, x: float, y: float, reach: float) -> list[tuple[float, float, float]]:
        """Movable boxes nearer than `reach` (m) to a point, as `moving_gaps`; 0 m when it is inside one."""
        found: list[tuple[float, float, float]] = []
        for index, there in enumerate(self.boxes):
            if math.hypot(x - there.x, y - there.y) < reach + self._reaches[index]:
                plan = Plan([Polygon(self._box_outline(index))])
                inside = plan.contains(x, y)
                found += [(0.0, 0.0, 0.0)] if inside else plan.gaps(x, y, reach)
        return found
