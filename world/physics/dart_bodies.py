"""The bodies of a DART world: robots of both models, movable boxes, and the fixed shapes near them.

A robot body is driven by wheel speeds and read as a pose; which joints and shapes it has is its own affair.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ..robot import CONTROL_PERIOD, RobotGeometry
from ..spec import Box, Cylinder, MovableBox, Polygon, Shape, Wall
from ._dart import dartpy

SUBSTEPS = 4
STEP = CONTROL_PERIOD / SUBSTEPS
"""Seconds of one physics step, so many of which make a control tick."""
SHELL_LOW, SHELL_HIGH = 0.008, 0.048
"""Heights (m) between which the shell stands."""
SHELL_FRICTION = 0.2
WHEEL_FRICTION = 1.0
TIRE_FRICTION = 0.8
"""What limits the force of the planar model, which has no wheels."""
CASTER_RADIUS, CASTER_OFFSET = 0.005, 0.028
WHEEL_MASS = 0.005
SINK = 4e-7
"""How deep (m) a robot's wheels are put into the floor, about as deep as its weight presses them, while its
casters just touch: wheels that carry little load slip when they start."""
MASS_HEIGHT = 0.015
GRAVITY = 9.81
LIFT = 0.002
"""Fixed shapes begin this high (m): touching the ground would cost contacts and gain nothing."""
WHEEL_SPEED_LIMIT = 100.0
"""rad/s: ODE aborts the process when a body gets absurdly fast, so nothing faster reaches it."""

State = tuple[float, float, float, float, float]
"""x, y, z (m), heading (rad), cosine of the tilt."""


class RobotBody(Protocol):
    """One robot's body in DART."""

    skeleton: Any
    rolling: Sequence[Any]
    """Its parts that may touch the floor and nothing else."""

    def drive(self, left: float, right: float) -> None:
        """Sets the wheels' speeds (rad/s) for the coming tick."""

    def before_step(self) -> None:
        """Called before every physics step of the tick."""

    def read(self) -> State:
        """Where the body is; the tilt's cosine is 1 when upright."""

    def put(self, x: float, y: float, heading: float) -> None:
        """Puts the body somewhere, at rest."""


class WheelsBody:
    """Chassis on a free joint, its origin on the axle; shell, two casters, two driven wheels.

    A wheel is a sphere, which touches the floor in one point, exactly a track from the other. It reaches
    beyond the shell, so it must be kept from touching anything else (`rolling`).
    """

    def __init__(self, name: str, geometry: RobotGeometry, track: float) -> None:
        """Builds the skeleton; track: true distance (m) of the wheels."""
        self._axle = geometry.wheel_radius
        self.skeleton = dartpy.dynamics.Skeleton(name)
        _, body = self.skeleton.createFreeJointAndBodyNodePair()
        self._add_chassis(body, geometry)
        self.rolling: Sequence[Any] = [self._add_wheel(body, offset) for offset in (track / 2, -track / 2)]

    def _add_chassis(self, body: Any, geometry: RobotGeometry) -> None:
        mass, radius, height = geometry.mass - 2 * WHEEL_MASS, geometry.body_radius, SHELL_HIGH - SHELL_LOW
        side = mass * (3 * radius**2 + height**2) / 12
        _set_inertia(body, mass, (side, side, mass * radius**2 / 2), (0.0, 0.0, MASS_HEIGHT - self._axle))
        middle = (SHELL_LOW + SHELL_HIGH) / 2 - self._axle
        _add_shape(body, dartpy.dynamics.CylinderShape(radius, height), _placed(0, 0, middle), SHELL_FRICTION)
        for offset in (CASTER_OFFSET, -CASTER_OFFSET):
            place = _placed(offset, 0, CASTER_RADIUS + SINK - self._axle)
            _add_shape(body, dartpy.dynamics.SphereShape(CASTER_RADIUS), place, 0.0)

    def _add_wheel(self, body: Any, offset: float) -> Any:
        joint, wheel = self.skeleton.createRevoluteJointAndBodyNodePair(body)
        joint.setAxis([0.0, 1.0, 0.0])
        joint.setTransformFromParentBodyNode(_placed(0, offset, 0))
        joint.setActuatorType(dartpy.dynamics.ActuatorType.VELOCITY)
        flat, spin = WHEEL_MASS * self._axle**2 / 4, WHEEL_MASS * self._axle**2 / 2
        _set_inertia(wheel, WHEEL_MASS, (flat, spin, flat), (0.0, 0.0, 0.0))
        _add_shape(wheel, dartpy.dynamics.SphereShape(self._axle), _placed(0, 0, 0), WHEEL_FRICTION)
        return wheel

    def drive(self, left: float, right: float) -> None:
        """See `RobotBody.drive`. Every tick, as setting velocities changes the commands too."""
        self.skeleton.setCommand(6, _limited(left))
        self.skeleton.setCommand(7, _limited(right))

    def before_step(self) -> None:
        """Nothing: the commands are kept from step to step."""

    def read(self) -> State:
        """See `RobotBody.read`."""
        turn_x, turn_y, turn_z, x, y, z, _, _ = self.skeleton.getPositions().tolist()
        heading, upright = heading_and_tilt(turn_x, turn_y, turn_z)
        return x, y, z - self._axle, heading, upright

    def put(self, x: float, y: float, heading: float) -> None:
        """See `RobotBody.put`; the wheels keep their angles."""
        wheels = self.skeleton.getPositions()[6:].tolist()
        self.skeleton.setPositions([0.0, 0.0, heading, x, y, self._axle - SINK, *wheels])
        self.skeleton.setVelocities(np.zeros(8))


class PlanarBody:
    """A shell on a planar joint, pulled by a servo no stronger than tires: it stops at walls, never tips."""

    def __init__(self, name: str, geometry: RobotGeometry, track: float) -> None:
        """Builds the skeleton; track: true distance (m) of the wheels."""
        self._radius, self._track = geometry.wheel_radius, track
        self._speed = self._turn = 0.0
        self._command = np.zeros(3)
        self.rolling: Sequence[Any] = ()
        self.skeleton = dartpy.dynamics.Skeleton(name)
        joint, body = self.skeleton.createPlanarJointAndBodyNodePair()
        joint.setActuatorType(dartpy.dynamics.ActuatorType.SERVO)
        force = geometry.mass * GRAVITY * TIRE_FRICTION
        for index, limit in enumerate((force, force, force * track / 2)):
            joint.setForceUpperLimit(index, limit)
            joint.setForceLowerLimit(index, -limit)
        radius, height = geometry.body_radius, SHELL_HIGH - SHELL_LOW
        side = geometry.mass * (3 * radius**2 + height**2) / 12
        _set_inertia(body, geometry.mass, (side, side, geometry.mass * radius**2 / 2), (0.0, 0.0, 0.0))
        place = _placed(0, 0, (SHELL_LOW + SHELL_HIGH) / 2)
        _add_shape(body, dartpy.dynamics.CylinderShape(radius, height), place, SHELL_FRICTION)

    def drive(self, left: float, right: float) -> None:
        """See `RobotBody.drive`."""
        left, right = _limited(left), _limited(right)
        self._speed = self._radius * (left + right) / 2
        self._turn = self._radius * (right - left) / self._track

    def before_step(self) -> None:
        """Turns the forward speed into the world's frame, at the heading in the middle of the step."""
        heading = self.skeleton.getPosition(2) + self._turn * STEP / 2
        command = self._command
        command[0], command[1] = self._speed * math.cos(heading), self._speed * math.sin(heading)
        command[2] = self._turn
        self.skeleton.setCommands(command)

    def read(self) -> State:
        """See `RobotBody.read`."""
        x, y, heading = self.skeleton.getPositions().tolist()
        return x, y, 0.0, heading, 1.0

    def put(self, x: float, y: float, heading: float) -> None:
        """See `RobotBody.put`."""
        self.skeleton.setPositions([x, y, heading])
        self.skeleton.setVelocities(np.zeros(3))


class MovableBody:
    """A box that can be pushed, on a free joint."""

    def __init__(self, name: str, movable: MovableBox) -> None:
        """Builds the skeleton and stands it on the floor."""
        box = movable.box
        self.reach = math.hypot(box.width, box.depth) / 2
        self._half = box.height / 2
        self.skeleton = dartpy.dynamics.Skeleton(name)
        _, body = self.skeleton.createFreeJointAndBodyNodePair()
        sizes = box.width, box.depth, box.height
        moments = tuple(movable.mass * (sum(size**2 for size in sizes) - own**2) / 12 for own in sizes)
        _set_inertia(body, movable.mass, (moments[0], moments[1], moments[2]), (0.0, 0.0, 0.0))
        _add_shape(body, dartpy.dynamics.BoxShape(list(sizes)), _placed(0, 0, 0), movable.friction)
        self.skeleton.setPositions([0.0, 0.0, box.angle, box.x, box.y, self._half])

    def read(self) -> State:
        """Where the box is."""
        turn_x, turn_y, turn_z, x, y, z = self.skeleton.getPositions().tolist()
        heading, upright = heading_and_tilt(turn_x, turn_y, turn_z)
        return x, y, z - self._half, heading, upright


def heading_and_tilt(x: float, y: float, z: float) -> tuple[float, float]:
    """Heading (rad) and cosine of the tilt of a body with this rotation vector (rad)."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-12:
        return z, 1.0
    x, y, z = x / angle, y / angle, z / angle
    cosine, sine = math.cos(angle), math.sin(angle)
    rest = 1.0 - cosine
    return math.atan2(z * sine + x * y * rest, cosine + x * x * rest), cosine + z * z * rest


def ground() -> Any:
    """A skeleton that is the floor."""
    skeleton = dartpy.dynamics.Skeleton("ground")
    _, body = skeleton.createWeldJointAndBodyNodePair()
    _add_shape(body, dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0), _placed(0, 0, 0), 1.0)
    return skeleton


def fixed(shapes: Sequence[Cylinder | Box]) -> Any:
    """One skeleton of all these shapes (many skeletons would be slow)."""
    skeleton = dartpy.dynamics.Skeleton("fixed")
    _, body = skeleton.createWeldJointAndBodyNodePair()
    for shape in shapes:
        if isinstance(shape, Cylinder):
            solid = dartpy.dynamics.CylinderShape(shape.radius, shape.height)
            turn = None
        else:
            solid = dartpy.dynamics.BoxShape([shape.width, shape.depth, shape.height])
            turn = _turned(shape.angle)
        _add_shape(body, solid, _placed(shape.x, shape.y, shape.height / 2 + LIFT, turn), 1.0)
    return skeleton


def solids(shape: Shape, rim: float = 0.004) -> list[Cylinder | Box]:
    """What stands for a shape in DART: itself, or a rim (m) of thin boxes inside a polygon's edges."""
    if isinstance(shape, Box | Cylinder):
        return [shape]
    if isinstance(shape, Wall):
        return [shape.box()]
    assert isinstance(shape, Polygon)
    points = shape.outline()
    return [
        _edge_box(before, start, end, after, rim, shape.height)
        for before, start, end, after in zip(
            (points[-1], *points[:-1]),
            points,
            (*points[1:], points[0]),
            (*points[2:], *points[:2]),
            strict=True,
        )
    ]


def _edge_box(
    before: tuple[float, float],
    start: tuple[float, float],
    end: tuple[float, float],
    after: tuple[float, float],
    rim: float,
    height: float,
) -> Box:
    """A thin box inside one edge; shortened at sharp corners, where it would stick out of the next edge."""
    (x0, y0), (x1, y1) = start, end
    length, angle = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
    rim = min(rim, length / 2)
    cut0, cut1 = _cut(before, start, end, rim), _cut(start, end, after, rim)
    if cut0 + cut1 > 0.9 * length:
        cut0 = cut1 = 0.45 * length
    middle = (cut0 + length - cut1) / 2
    x = x0 + middle * math.cos(angle) - rim / 2 * math.sin(angle)
    y = y0 + middle * math.sin(angle) + rim / 2 * math.cos(angle)
    return Box(x, y, length - cut0 - cut1, rim, angle, height)


def _cut(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], rim: float) -> float:
    inner = math.pi - math.remainder(
        math.atan2(c[1] - b[1], c[0] - b[0]) - math.atan2(b[1] - a[1], b[0] - a[0]), math.tau
    )
    return rim / math.tan(inner) if 1e-3 < inner < math.pi / 2 else 0.0


def _limited(speed: float) -> float:
    return max(-WHEEL_SPEED_LIMIT, min(WHEEL_SPEED_LIMIT, speed))


def _placed(x: float, y: float, z: float, rotation: Any = None) -> Any:
    place = dartpy.math.Isometry3()
    place.set_translation([x, y, z])
    if rotation is not None:
        place.set_rotation(np.array(rotation, dtype=float))
    return place


def _turned(angle: float) -> list[list[float]]:
    cosine, sine = math.cos(angle), math.sin(angle)
    return [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]


def _add_shape(body: Any, shape: Any, place: Any, friction: float) -> None:
    node = body.createShapeNode(shape)
    node.setRelativeTransform(place)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    node.getDynamicsAspect().setFrictionCoeff(friction)


def _set_inertia(
    body: Any, mass: float, moments: tuple[float, float, float], center: tuple[float, float, float]
) -> None:
    body.setInertia(dartpy.dynamics.Inertia(mass, list(center), np.diag(moments)))
