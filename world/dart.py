"""Worlds simulated with DART.

Recipe (measured, see docs/decisions): ODE collision detection, a plane as ground, the fixed shapes near the
robots in one skeleton, four physics steps of 8 ms a control tick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._dart import dartpy
from .base import SimulationError
from .dart_bodies import GRAVITY, MovableBody, PlanarBody, RobotBody, WheelsBody, fixed, ground, solids
from .geometry import Floats, outline
from .robot import CONTROL_PERIOD, Pose
from .simulated import SimulatedWorld
from .spec import Box, Cylinder

SUBSTEPS = 4
STEP = CONTROL_PERIOD / SUBSTEPS
"""Seconds of one physics step."""
TILT_LIMIT = math.cos(math.radians(20.0))
SINK_LIMIT, RISE_LIMIT = -0.01, 0.02
"""How far (m) a robot's axle may be off its height before the run is given up."""
BODIES: dict[str, type[WheelsBody] | type[PlanarBody]] = {"wheels": WheelsBody, "planar": PlanarBody}


class DartWorld(SimulatedWorld):
    """Robots and movable boxes under physics, among fixed shapes."""

    def __init__(self, *args: Any, model: str = "wheels", **options: Any) -> None:
        """See `SimulatedWorld`; model: "wheels" or "planar"."""
        self.kind = f"dart-{model}"
        super().__init__(*args, **options)
        self._world: Any = dartpy.simulation.World(f"tolman-{self.spec.name}")
        self._world.setTimeStep(STEP)
        self._world.setGravity([0.0, 0.0, -GRAVITY])
        self._world.getConstraintSolver().setCollisionDetector(dartpy.collision.OdeCollisionDetector())
        self._world.addSkeleton(ground())
        track = self.geometry.track * (1.0 + self.noise.wrong_track)
        self._robots: list[RobotBody] = [
            BODIES[model](f"robot-{index}", self.geometry, track) for index in range(len(self._poses))
        ]
        self._boxes = [
            MovableBody(f"movable-{index}", movable) for index, movable in enumerate(self.spec.movable)
        ]
        self._skeletons: list[Any] = [robot.skeleton for robot in self._robots]
        self._skeletons += [box.skeleton for box in self._boxes]
        for skeleton in self._skeletons:
            self._world.addSkeleton(skeleton)
        for robot, pose in zip(self._robots, self._poses, strict=True):
            robot.put(pose.x, pose.y, pose.heading)
        self.nearby = Nearby(self._world, self.spec.shapes, [movable.box for movable in self.spec.movable])
        self.nearby.follow(self._places())

    def _advance(self, speeds: Sequence[tuple[float, float]]) -> None:
        for robot, (left, right) in zip(self._robots, speeds, strict=True):
            robot.drive(left, right)
        step = self._world.step
        for _ in range(SUBSTEPS):
            for robot in self._robots:
                robot.before_step()
            step(False)
        self._movable_poses = [self._box_pose(index) for index in range(len(self._boxes))]
        self.nearby.follow(self._places())

    def _read(self, index: int) -> Pose:
        x, y, rise, heading, upright = self._robots[index].read()
        if not (upright > TILT_LIMIT and SINK_LIMIT < rise < RISE_LIMIT):  # also when not a number
            raise SimulationError(
                f"robot {index} tipped or flew off after {self.time:.3f} s: near ({x:.3f}, {y:.3f}), "
                f"{rise * 1000:.1f} mm up, tilt cosine {upright:.3f} (limit {TILT_LIMIT:.3f}); the run ends"
            )
        return Pose(x, y, math.remainder(heading, math.tau))

    def _box_pose(self, index: int) -> Pose:
        x, y, rise, heading, _ = self._boxes[index].read()
        if not abs(rise) < 1.0:
            raise SimulationError(f"movable box {index} flew off after {self.time:.3f} s; the run ends")
        return Pose(x, y, heading)

    def _places(self) -> list[tuple[float, float]]:
        return [(pose.x, pose.y) for pose in (*self._poses, *self._movable_poses)]

    def _put(self, index: int, pose: Pose) -> None:
        self._robots[index].put(pose.x, pose.y, pose.heading)
        self._poses[index] = pose
        self.nearby.follow(self._places())

    def _bodies(self) -> Any:
        return {
            "near": self.nearby.anchors,
            "bodies": [
                [body.getPositions().tolist(), body.getVelocities().tolist()] for body in self._skeletons
            ],
        }

    def _restore_bodies(self, bodies: Any) -> None:
        for skeleton, (positions, velocities) in zip(self._skeletons, bodies["bodies"], strict=True):
            skeleton.setPositions(positions)
            skeleton.setVelocities(velocities)
        self.nearby.gather([(float(x), float(y)) for x, y in bodies["near"]])
        self._movable_poses = [self._box_pose(index) for index in range(len(self._boxes))]

    def close(self) -> None:
        """Drops the DART world."""
        super().close()
        self._robots, self._boxes, self._skeletons = [], [], []
        self._world = None


class Nearby:
    """Keeps only the fixed shapes near a body in the DART world, as its cost is per shape."""

    SLACK = 0.10
    """How far (m) a body moves before the shapes around it are gathered anew."""
    REACH = 0.08
    """How near (m), beyond the slack and the body's own size, a shape must be to be kept."""

    def __init__(self, world: Any, shapes: Sequence[Any], movable: Sequence[Box]) -> None:
        """Remembers all shapes; `follow` brings in the first."""
        self._world = world
        self._solids: list[Cylinder | Box] = [solid for shape in shapes for solid in solids(shape)]
        corners = [np.array(outline(solid)) for solid in self._solids]
        self._low: Floats = np.array([points.min(axis=0) for points in corners]).reshape(-1, 2)
        self._high: Floats = np.array([points.max(axis=0) for points in corners]).reshape(-1, 2)
        widest = max((math.hypot(box.width, box.depth) / 2 for box in movable), default=0.0)
        self._reach = self.SLACK + self.REACH + max(0.035, widest)
        self.kept: list[int] = []
        self._skeleton: Any = None
        self.anchors: list[tuple[float, float]] = []

    def follow(self, places: list[tuple[float, float]]) -> None:
        """Gathers anew when a body has moved away from where it was at the last time."""
        limit = self.SLACK**2
        if len(places) != len(self.anchors) or any(
            (x - x0) ** 2 + (y - y0) ** 2 > limit
            for (x, y), (x0, y0) in zip(places, self.anchors, strict=True)
        ):
            self.gather(places)

    def gather(self, places: list[tuple[float, float]]) -> None:
        """Puts the shapes near `places` into the world, in the order of the description."""
        self.anchors = list(places)
        near = np.zeros(len(self._solids), dtype=bool)
        for place in places:
            gap = np.maximum(np.maximum(self._low - place, place - self._high), 0.0)
            near |= (gap**2).sum(axis=1) < self._reach**2
        kept: list[int] = np.flatnonzero(near).tolist()
        if kept == self.kept:
            return
        self.kept = kept
        if self._skeleton is not None:
            self._world.removeSkeleton(self._skeleton)
        self._skeleton = fixed([self._solids[index] for index in kept]) if kept else None
        if self._skeleton is not None:
            self._world.addSkeleton(self._skeleton)
