"""Worlds simulated with DART: the only module that imports dartpy.

Recipe (measured, see docs/decisions): ODE collision detection, a plane as ground, all fixed shapes in one
skeleton, the e-puck as a chassis with two casters and two wheels, four steps of 8 ms a tick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import dartpy
import numpy as np

from .base import SimulationError
from .geometry import outline, wall_box
from .robot import CONTROL_PERIOD, Pose, RobotGeometry
from .simulated import SimulatedWorld
from .spec import Box, Cylinder, Polygon, Shape, Wall

SUBSTEPS = 4
STEP = CONTROL_PERIOD / SUBSTEPS
"""Seconds of one physics step."""
SHELL_LOW, SHELL_HIGH = 0.008, 0.048
"""Heights (m) between which the shell stands."""
SHELL_FRICTION = 0.2
WHEEL_FRICTION = 1.0
CASTER_RADIUS, CASTER_OFFSET = 0.005, 0.028
WHEEL_MASS = 0.005
MASS_HEIGHT = 0.015
TILT_LIMIT = math.cos(math.radians(20.0))
WHEEL_SPEED_LIMIT = 100.0
"""rad/s: ODE aborts the process when a body gets absurdly fast, so nothing faster reaches it."""


class DartWorld(SimulatedWorld):
    """The *wheels* robot under physics: it stops at walls while its wheels go on turning."""

    kind = "dart-wheels"

    def __init__(self, *args: Any, **options: Any) -> None:
        """See `SimulatedWorld`; builds the DART world."""
        super().__init__(*args, **options)
        self._world: Any = dartpy.simulation.World(f"tolman-{self.spec.name}")
        self._world.setTimeStep(STEP)
        self._world.setGravity([0.0, 0.0, -9.81])
        self._world.getConstraintSolver().setCollisionDetector(dartpy.collision.OdeCollisionDetector())
        self._world.addSkeleton(_ground())
        self._world.addSkeleton(_fixed(self.spec.shapes))
        track = self.geometry.track * (1.0 + self.noise.wrong_track)
        self._skeletons: list[Any] = []
        for index, pose in enumerate(self._poses):
            skeleton = _wheels_robot(f"robot-{index}", self.geometry, track)
            self._world.addSkeleton(skeleton)
            self._skeletons.append(skeleton)
            self._put(index, pose)

    def _advance(self, speeds: Sequence[tuple[float, float]]) -> None:
        commands = [
            np.array((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, _limited(left), _limited(right)))
            for left, right in speeds
        ]
        for skeleton, command in zip(self._skeletons, commands, strict=True):
            skeleton.setCommands(command)
        step = self._world.step
        for _ in range(SUBSTEPS):
            step(False)

    def _read(self, index: int) -> Pose:
        turn_x, turn_y, turn_z, x, y, z = self._skeletons[index].getPositions()[:6].tolist()
        heading, upright = heading_and_tilt(turn_x, turn_y, turn_z)
        if not upright > TILT_LIMIT:  # also when it is not a number
            raise SimulationError(
                f"robot {index} tipped over or flew off after {self.time:.3f} s; the run ends"
            )
        if not -0.01 < z - self.geometry.wheel_radius < 0.02:
            raise SimulationError(
                f"robot {index} left the floor after {self.time:.3f} s (axle at {z:.3f} m); the run ends"
            )
        return Pose(x, y, heading)

    def _put(self, index: int, pose: Pose) -> None:
        skeleton = self._skeletons[index]
        wheels = skeleton.getPositions()[6:].tolist()
        skeleton.setPositions([0.0, 0.0, pose.heading, pose.x, pose.y, self.geometry.wheel_radius, *wheels])
        skeleton.setVelocities(np.zeros(8))

    def _bodies(self) -> Any:
        return [
            [skeleton.getPositions().tolist(), skeleton.getVelocities().tolist()]
            for skeleton in self._skeletons
        ]

    def _restore_bodies(self, bodies: Any) -> None:
        for skeleton, (positions, velocities) in zip(self._skeletons, bodies, strict=True):
            skeleton.setPositions(positions)
            skeleton.setVelocities(velocities)

    def close(self) -> None:
        """Drops the DART world."""
        super().close()
        self._skeletons = []
        self._world = None


def heading_and_tilt(x: float, y: float, z: float) -> tuple[float, float]:
    """Heading (rad) and cosine of the tilt of a body with this rotation vector (rad)."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-12:
        return z, 1.0
    x, y, z = x / angle, y / angle, z / angle
    cosine, sine = math.cos(angle), math.sin(angle)
    rest = 1.0 - cosine
    return math.atan2(z * sine + x * y * rest, cosine + x * x * rest), cosine + z * z * rest


def _limited(speed: float) -> float:
    return max(-WHEEL_SPEED_LIMIT, min(WHEEL_SPEED_LIMIT, speed))


def _placed(x: float, y: float, z: float, rotation: Any = None) -> Any:
    place = dartpy.math.Isometry3()
    place.set_translation([x, y, z])
    if rotation is not None:
        place.set_rotation(np.array(rotation, dtype=float))
    return place


def _add_shape(body: Any, shape: Any, place: Any, friction: float) -> None:
    node = body.createShapeNode(shape)
    node.setRelativeTransform(place)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    node.getDynamicsAspect().setFrictionCoeff(friction)


def _ground() -> Any:
    skeleton = dartpy.dynamics.Skeleton("ground")
    _, body = skeleton.createWeldJointAndBodyNodePair()
    _add_shape(body, dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0), _placed(0, 0, 0), 1.0)
    return skeleton


def _fixed(shapes: Sequence[Shape]) -> Any:
    skeleton = dartpy.dynamics.Skeleton("fixed")
    _, body = skeleton.createWeldJointAndBodyNodePair()
    for shape in shapes:
        if isinstance(shape, Cylinder):
            place = _placed(shape.x, shape.y, shape.height / 2)
            _add_shape(body, dartpy.dynamics.CylinderShape(shape.radius, shape.height), place, 1.0)
        for box in collision_boxes(shape):
            place = _placed(box.x, box.y, box.height / 2, _turned(box.angle))
            _add_shape(body, dartpy.dynamics.BoxShape([box.width, box.depth, box.height]), place, 1.0)
    return skeleton


def collision_boxes(shape: Shape, rim: float = 0.004) -> list[Box]:
    """The boxes that stand for a shape in DART: itself, or a rim of thin boxes inside a polygon's edges."""
    if isinstance(shape, Box):
        return [shape]
    if isinstance(shape, Wall):
        return [wall_box(shape)]
    if not isinstance(shape, Polygon):
        return []
    points = outline(shape)
    boxes = []
    for (x0, y0), (x1, y1) in zip(points, (*points[1:], points[0]), strict=True):
        length, angle = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
        inward_x, inward_y = -math.sin(angle) * rim / 2, math.cos(angle) * rim / 2
        boxes.append(
            Box((x0 + x1) / 2 + inward_x, (y0 + y1) / 2 + inward_y, length, rim, angle, shape.height)
        )
    return boxes


def _turned(angle: float) -> list[list[float]]:
    cosine, sine = math.cos(angle), math.sin(angle)
    return [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]


def _set_inertia(
    body: Any, mass: float, moments: tuple[float, float, float], center: tuple[float, float, float]
) -> None:
    inertia = dartpy.dynamics.Inertia(mass, list(center), np.diag(moments))
    body.setInertia(inertia)


def _wheels_robot(name: str, geometry: RobotGeometry, track: float) -> Any:
    """Chassis on a free joint, its origin on the axle; shell, two casters, two driven wheels."""
    skeleton = dartpy.dynamics.Skeleton(name)
    _, body = skeleton.createFreeJointAndBodyNodePair()
    axle = geometry.wheel_radius
    mass = geometry.mass - 2 * WHEEL_MASS
    radius, height = geometry.body_radius, SHELL_HIGH - SHELL_LOW
    side = mass * (3 * radius**2 + height**2) / 12
    _set_inertia(body, mass, (side, side, mass * radius**2 / 2), (0.0, 0.0, MASS_HEIGHT - axle))
    middle = (SHELL_LOW + SHELL_HIGH) / 2 - axle
    _add_shape(body, dartpy.dynamics.CylinderShape(radius, height), _placed(0, 0, middle), SHELL_FRICTION)
    for offset in (CASTER_OFFSET, -CASTER_OFFSET):
        place = _placed(offset, 0, CASTER_RADIUS - axle)
        _add_shape(body, dartpy.dynamics.SphereShape(CASTER_RADIUS), place, 0.0)
    for offset in (track / 2, -track / 2):
        joint, wheel = skeleton.createRevoluteJointAndBodyNodePair(body)
        joint.setAxis([0.0, 1.0, 0.0])
        joint.setTransformFromParentBodyNode(_placed(0, offset, 0))
        joint.setActuatorType(dartpy.dynamics.ActuatorType.VELOCITY)
        flat, spin = WHEEL_MASS * axle**2 / 4, WHEEL_MASS * axle**2 / 2
        _set_inertia(wheel, WHEEL_MASS, (flat, spin, flat), (0.0, 0.0, 0.0))
        on_axle = _placed(0, 0, 0, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        _add_shape(wheel, dartpy.dynamics.CylinderShape(axle, 1e-5), on_axle, WHEEL_FRICTION)
    return skeleton
