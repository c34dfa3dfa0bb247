"""What tolman is measured against: a raw loop of dartpy, and ir-sim, each with one robot among boxes."""

from __future__ import annotations

import contextlib
import importlib
import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import dartpy
import numpy as np
from tolman.world import CONTROL_PERIOD, EPUCK
from tolman.world.spec import Box

SUBSTEPS = 4


def raw_dart(boxes: Sequence[Box], model: str) -> Callable[[], None]:
    """One control tick of plain dartpy: set the wheels' speeds, four steps of 8 ms, read the pose.

    Written as anyone would who knows DART, with what makes it fast (ODE, a plane as floor, all boxes in one
    skeleton), and without what tolman adds: it senses nothing, decides nothing, and keeps all boxes in.
    """
    world = dartpy.simulation.World("raw")
    world.setTimeStep(CONTROL_PERIOD / SUBSTEPS)
    world.setGravity([0.0, 0.0, -9.81])
    world.getConstraintSolver().setCollisionDetector(dartpy.collision.OdeCollisionDetector())
    floor, body = _welded("floor")
    _shape(body, dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0), (0.0, 0.0, 0.0), 1.0)
    world.addSkeleton(floor)
    fixed, body = _welded("boxes")
    for box in boxes:
        solid = dartpy.dynamics.BoxShape([box.width, box.depth, box.height])
        _shape(body, solid, (box.x, box.y, box.height / 2), 1.0)
    world.addSkeleton(fixed)
    return _raw_wheels(world) if model == "wheels" else _raw_planar(world)


def _welded(name: str) -> tuple[Any, Any]:
    skeleton = dartpy.dynamics.Skeleton(name)
    return skeleton, skeleton.createWeldJointAndBodyNodePair()[1]


def _shape(body: Any, shape: Any, place: Sequence[float], friction: float, turn: Any = None) -> None:
    node = body.createShapeNode(shape)
    pose = dartpy.math.Isometry3()
    pose.set_translation(list(place))
    if turn is not None:
        pose.set_rotation(np.array(turn, dtype=float))
    node.setRelativeTransform(pose)
    node.createCollisionAspect()
    node.createDynamicsAspect()
    node.getDynamicsAspect().setFrictionCoeff(friction)


def _inertia(body: Any, mass: float, moments: Sequence[float], height: float) -> None:
    body.setInertia(dartpy.dynamics.Inertia(mass, [0.0, 0.0, height], np.diag(moments)))


def _raw_wheels(world: Any) -> Callable[[], None]:
    axle = EPUCK.wheel_radius
    robot = dartpy.dynamics.Skeleton("robot")
    _, body = robot.createFreeJointAndBodyNodePair()
    _inertia(body, 0.14, (6e-5, 6e-5, 9e-5), 0.015 - axle)
    _shape(body, dartpy.dynamics.CylinderShape(0.035, 0.04), (0.0, 0.0, 0.028 - axle), 0.2)
    for x in (0.028, -0.028):
        _shape(body, dartpy.dynamics.SphereShape(0.005), (x, 0.0, 0.005 - axle), 0.0)
    for y in (EPUCK.track / 2, -EPUCK.track / 2):
        joint, wheel = robot.createRevoluteJointAndBodyNodePair(body)
        joint.setAxis([0.0, 1.0, 0.0])
        place = dartpy.math.Isometry3()
        place.set_translation([0.0, y, 0.0])
        joint.setTransformFromParentBodyNode(place)
        joint.setActuatorType(dartpy.dynamics.ActuatorType.VELOCITY)
        _inertia(wheel, 0.005, (5e-7, 1e-6, 5e-7), 0.0)
        lying = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        _shape(wheel, dartpy.dynamics.CylinderShape(axle, 1e-5), (0.0, 0.0, 0.0), 1.0, lying)
    world.addSkeleton(robot)
    robot.setPositions([0.0, 0.0, 0.0, 0.3, 0.057, axle, 0.0, 0.0])
    commands = np.zeros(8)
    tick = iter(range(2**62))

    def step() -> None:
        commands[6:] = _circling(next(tick))
        robot.setCommands(commands)
        for _ in range(SUBSTEPS):
            world.step(False)
        robot.getPositions()

    return step


def _raw_planar(world: Any) -> Callable[[], None]:
    robot = dartpy.dynamics.Skeleton("robot")
    joint, body = robot.createPlanarJointAndBodyNodePair()
    joint.setActuatorType(dartpy.dynamics.ActuatorType.SERVO)
    force = 0.15 * 9.81 * 0.8
    for index, limit in enumerate((force, force, force * EPUCK.track / 2)):
        joint.setForceUpperLimit(index, limit)
        joint.setForceLowerLimit(index, -limit)
    _inertia(body, 0.15, (6e-5, 6e-5, 9e-5), 0.0)
    _shape(body, dartpy.dynamics.CylinderShape(0.035, 0.04), (0.0, 0.0, 0.028), 0.2)
    world.addSkeleton(robot)
    robot.setPositions([0.3, 0.057, 0.0])
    tick = iter(range(2**62))
    half = CONTROL_PERIOD / SUBSTEPS / 2

    def step() -> None:
        speed, turn = _speed_and_turn(next(tick))
        for _ in range(SUBSTEPS):
            heading = robot.getPosition(2) + turn * half
            robot.setCommands([speed * math.cos(heading), speed * math.sin(heading), turn])
            world.step(False)
        robot.getPositions()

    return step


def _circling(tick: int) -> tuple[float, float]:
    """Wheel speeds (rad/s) that change every tick: ahead and back on the spot, slowly turning."""
    ahead = 1.46 if tick // 100 % 2 == 0 else -1.46
    return ahead, ahead + 0.01 * (tick % 7)


def _speed_and_turn(tick: int) -> tuple[float, float]:
    """The same for who has no wheels (m/s, rad/s)."""
    left, right = _circling(tick)
    return EPUCK.wheel_radius * (left + right) / 2, EPUCK.wheel_radius * (right - left) / EPUCK.track


def ir_sim(boxes: Sequence[Box], side: float) -> Callable[[], None] | None:
    """One tick of ir-sim: a differential robot with a lidar of 8 beams among the boxes; None without it."""
    try:
        with contextlib.redirect_stdout(sys.stderr):  # it says which windows it cannot open
            irsim = importlib.import_module("irsim")
    except ImportError:
        return None
    obstacles = "".join(
        f"  - shape: {{name: rectangle, length: {box.width}, width: {box.depth}}}\n"
        f"    state: [{box.x}, {box.y}, {box.angle}]\n"
        for box in boxes
    )
    text = (
        f"world: {{height: {side + 0.2}, width: {side + 0.2}, offset: [-0.1, -0.1], "
        f"step_time: {CONTROL_PERIOD}, sample_time: {CONTROL_PERIOD}, collision_mode: 'stop'}}\n"
        "robot:\n"
        "  - kinematics: {name: diff}\n"
        "    shape: {name: circle, radius: 0.035}\n"
        "    state: [0.3, 0.057, 0.0]\n"
        "    goal: [1000.0, 1000.0, 0.0]\n"
        "    vel_max: [0.13, 5.0]\n"
        "    sensors:\n"
        "      - {type: lidar2d, range_min: 0, range_max: 0.5, angle_range: 6.28, number: 8}\n"
        f"obstacle:\n{obstacles}"
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "boxes.yaml")
        path.write_text(text)
        env = irsim.make(str(path), headless=True, display=False, log_level="ERROR")
    tick = iter(range(2**62))

    def step() -> None:
        speed, turn = _speed_and_turn(next(tick))
        env.step(np.array([[speed], [turn]]))
        env.get_lidar_scan()

    return step
