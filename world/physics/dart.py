"""Worlds simulated with DART.

Recipe (measured, see docs/decisions): ODE collision detection, a plane as ground, the fixed shapes near the
robots in one skeleton, four physics steps of 8 ms a control tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

from ..errors import SimulationError
from ..robot import Pose
from ._dart import dartpy
from .broad_phase import BroadPhase
from .dart_bodies import (
    GRAVITY,
    STEP,
    SUBSTEPS,
    MovableBody,
    PlanarBody,
    RobotBody,
    WheelsBody,
    fixed,
    ground,
    solids,
)
from .simulated import SimulatedWorld

TILT_LIMIT = math.cos(math.radians(20.0))
SINK_LIMIT, RISE_LIMIT = -0.01, 0.02
"""How far (m) a robot's axle may be off its height before the run is given up."""
REMEMBERED = 64
"""How many sets of fixed shapes are kept at hand."""
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
        self._ignored: Any = self._world.getConstraintSolver().getCollisionOption().collisionFilter
        self._world.addSkeleton(ground())
        track = self.geometry.track * (1.0 + self.noise.wrong_track)
        self._robots: list[RobotBody] = [
            BODIES[model](f"robot-{index}", self.geometry, track)
            for index in range(len(self.surroundings.robots))
        ]
        self._boxes = [
            MovableBody(f"movable-{index}", movable) for index, movable in enumerate(self.spec.movable)
        ]
        self._skeletons: list[Any] = [robot.skeleton for robot in self._robots]
        self._skeletons += [box.skeleton for box in self._boxes]
        for skeleton in self._skeletons:
            self._world.addSkeleton(skeleton)
        for robot, pose in zip(self._robots, self.surroundings.robots, strict=True):
            robot.put(pose.x, pose.y, pose.heading)
        self._keep_wheels_to_the_floor()
        self.broad_phase = BroadPhase(
            [solid for shape in self.spec.shapes for solid in solids(shape)],
            max([self.geometry.body_radius, *(box.reach for box in self._boxes)]),
        )
        self._fixed: dict[tuple[int, ...], Any] = {}
        self._around: Any = None
        self._surround(self.broad_phase.follow(self._places()))

    def _advance(self, speeds: Sequence[tuple[float, float]]) -> None:
        for robot, (left, right) in zip(self._robots, speeds, strict=True):
            robot.drive(left, right)
        step = self._world.step
        for _ in range(SUBSTEPS):
            for robot in self._robots:
                robot.before_step()
            step(False)
        if self._boxes:
            self.surroundings.boxes = [self._box_pose(index) for index in range(len(self._boxes))]
        self._surround(self.broad_phase.follow(self._places()))

    def _keep_wheels_to_the_floor(self) -> None:
        """Has DART ignore contacts of wheels with anything that moves; for what is fixed see `_surround`."""
        for robot in self._robots:
            others = chain.from_iterable(
                skeleton.getBodyNodes() for skeleton in self._skeletons if skeleton is not robot.skeleton
            )
            for body in others:
                for wheel in robot.rolling:
                    self._ignored.addBodyNodePairToBlackList(wheel, body)

    def _surround(self, kept: tuple[int, ...] | None) -> None:
        """Puts these fixed shapes into the physics in place of those there; None: they have not changed."""
        if kept is None:
            return
        if self._around is not None:
            self._world.removeSkeleton(self._around)
        self._around = self._fixed_skeleton(kept) if kept else None
        if self._around is not None:
            self._world.addSkeleton(self._around)

    def _fixed_skeleton(self, kept: tuple[int, ...]) -> Any:
        """The skeleton of these shapes; the last ones are remembered: making one costs more than a tick."""
        skeleton = self._fixed.pop(kept, None)
        if skeleton is None:
            skeleton = fixed([self.broad_phase.solids[index] for index in kept])
            self._exempt(skeleton, self._ignored.addBodyNodePairToBlackList)
            if len(self._fixed) >= REMEMBERED:
                oldest = next(iter(self._fixed))
                self._exempt(self._fixed.pop(oldest), self._ignored.removeBodyNodePairFromBlackList)
        self._fixed[kept] = skeleton
        return skeleton

    def _exempt(self, skeleton: Any, change: Callable[[Any, Any], None]) -> None:
        """Applies `change` of the ignored pairs to each wheel and the one body of a fixed skeleton."""
        body = skeleton.getBodyNode(0)
        for robot in self._robots:
            for wheel in robot.rolling:
                change(wheel, body)

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
        return [(pose.x, pose.y) for pose in (*self.surroundings.robots, *self.surroundings.boxes)]

    def _put(self, index: int, pose: Pose) -> None:
        self._robots[index].put(pose.x, pose.y, pose.heading)
        self.surroundings.robots[index] = pose
        self._surround(self.broad_phase.follow(self._places()))

    def _bodies(self) -> Any:
        return {
            "near": self.broad_phase.anchors,
            "bodies": [
                [body.getPositions().tolist(), body.getVelocities().tolist()] for body in self._skeletons
            ],
        }

    def _restore_bodies(self, bodies: Any) -> None:
        for skeleton, (positions, velocities) in zip(self._skeletons, bodies["bodies"], strict=True):
            skeleton.setPositions(positions)
            skeleton.setVelocities(velocities)
        self._surround(self.broad_phase.gather([(float(x), float(y)) for x, y in bodies["near"]]))
        self.surroundings.boxes = [self._box_pose(index) for index in range(len(self._boxes))]

    def close(self) -> None:
        """Drops the DART world."""
        super().close()
        self._robots, self._boxes, self._skeletons = [], [], []
        self._fixed, self._around = {}, None
        self._world = self._ignored = None
