"""What all simulated worlds share: robots with noisy wheels and sensors, time, placing, state.

A subclass moves the bodies (`_advance`, `_read`, `_put`); everything a robot senses is computed here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

from .base import PlacementError, SimulationError, WorldError
from .camera import Camera
from .epuck import SimulatedRobot
from .geometry import Floats, Plan
from .infrared import InfraredModel
from .noise import Noise
from .rays import Caster, make_caster
from .robot import CONTROL_PERIOD, EPUCK, Image, Pose, RobotGeometry
from .scene import Faces
from .spec import WorldSpec

TOUCH = 5e-5
"""The shell counts as touching below this distance (m)."""
STATE_VERSION = 1


class SimulatedWorld(ABC):
    """The common part of the worlds; see `base.World` for the contract."""

    kind = ""

    def __init__(
        self,
        spec: WorldSpec,
        starts: Sequence[Pose],
        *,
        seed: int = 0,
        noise: Noise | None = None,
        geometry: RobotGeometry = EPUCK,
        rays: str = "auto",
    ) -> None:
        """Builds the world with one robot at each of `starts`.

        Raises: PlacementError when a start overlaps something.
        """
        self.spec = spec
        self.seed = seed
        self.geometry = geometry
        self.noise = noise or Noise()
        self._rays = rays
        self._plan = Plan(spec.shapes)
        self._infrared = InfraredModel(geometry)
        self._seen = Plan(spec.shapes, min_height=self._infrared.height)
        self._camera = Camera(geometry, spec.scenery)
        self._faces = Faces(spec.shapes)
        self._caster: Caster | None = None
        self._brightness = self._camera.brightness(self._faces)
        self._tick = 0
        self._open = True
        self._poses = list(starts)
        self.robots: list[SimulatedRobot] = [
            SimulatedRobot(self, index, geometry, self.noise, seed) for index in range(len(starts))
        ]
        for index, pose in enumerate(starts):
            self._check_place(pose, index, range(index))

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return self._tick * CONTROL_PERIOD

    @property
    def tick(self) -> int:
        """Control ticks since the start."""
        return self._tick

    def step(self) -> None:
        """See `base.World.step`."""
        if not self._open:
            raise WorldError(f"world {self.spec.name!r} is closed")
        self._advance([robot.wheel_speeds() for robot in self.robots])
        self._tick += 1
        for index, robot in enumerate(self.robots):
            pose = self._poses[index] = self._checked(self._read(index), index)
            robot.count_encoders()
            if self._touching(pose, index):
                robot.collisions += 1
            robot.sample(self._tick, self.time, pose)

    def true_pose(self, robot: int = 0) -> Pose:
        """See `base.World.true_pose`."""
        return self._poses[robot]

    def collisions(self, robot: int = 0) -> int:
        """See `base.World.collisions`."""
        return self.robots[robot].collisions

    def clearance(self, x: float, y: float) -> float:
        """See `base.World.clearance`."""
        return self._plan.clearance(x, y)

    def place(self, pose: Pose, robot: int = 0) -> None:
        """See `base.World.place`."""
        others = [index for index in range(len(self.robots)) if index != robot]
        self._check_place(pose, robot, others)
        self._put(robot, pose)
        self._poses[robot] = pose
        self.robots[robot].stop(self._tick, self.time, pose)

    def state(self) -> dict[str, Any]:
        """See `base.World.state`."""
        return {
            "version": STATE_VERSION,
            "kind": self.kind,
            "world": self.spec.digest,
            "tick": self._tick,
            "poses": [[pose.x, pose.y, pose.heading] for pose in self._poses],
            "robots": [robot.state() for robot in self.robots],
            "bodies": self._bodies(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """See `base.World.restore`."""
        for key, mine in (("version", STATE_VERSION), ("kind", self.kind), ("world", self.spec.digest)):
            if state.get(key) != mine:
                raise WorldError(f"this state is of another {key}: {state.get(key)!r}, not {mine!r}")
        if len(state["robots"]) != len(self.robots):
            raise WorldError(f"this state has {len(state['robots'])} robots, the world {len(self.robots)}")
        self._tick = int(state["tick"])
        self._poses = [Pose(*map(float, pose)) for pose in state["poses"]]
        self._restore_bodies(state["bodies"])
        for robot, saved in zip(self.robots, state["robots"], strict=True):
            robot.restore(saved)

    def close(self) -> None:
        """See `base.World.close`."""
        self._open = False

    def infrared_values(self, index: int, pose: Pose) -> Floats:
        """Noise-free raw values (8,) of one robot's sensors at a pose."""
        return self._infrared.values(self._infrared.distances(pose, self._seen))

    def infrared_model(self) -> InfraredModel:
        """The response of the infrared sensors."""
        return self._infrared

    def render(self, index: int, width: int, height: int) -> Image:
        """What one robot's camera sees now, without noise."""
        if self._caster is None:
            self._caster = make_caster(self._faces, self._rays)
        return self._camera.render(self._poses[index], width, height, self._caster, self._brightness)

    def _touching(self, pose: Pose, index: int) -> bool:
        radius = self.geometry.body_radius
        if self._plan.gaps(pose.x, pose.y, radius + TOUCH):
            return True
        return any(
            other != index and pose.distance_to(there) < 2 * radius + TOUCH
            for other, there in enumerate(self._poses)
        )

    def _checked(self, pose: Pose, index: int) -> Pose:
        if not (math.isfinite(pose.x) and math.isfinite(pose.y) and math.isfinite(pose.heading)):
            raise SimulationError(
                f"robot {index} is at {pose} after {self.time:.3f} s: not finite; the run ends"
            )
        return pose

    def _check_place(self, pose: Pose, index: int, others: Sequence[int]) -> None:
        if not (math.isfinite(pose.x) and math.isfinite(pose.y) and math.isfinite(pose.heading)):
            raise PlacementError(f"robot {index} cannot start at {pose}: not finite")
        radius = self.geometry.body_radius
        where = f"({pose.x:.3f}, {pose.y:.3f})"
        gap = self._plan.clearance(pose.x, pose.y)
        if gap < radius:
            raise PlacementError(
                f"robot {index} at {where} in world {self.spec.name!r} would overlap a wall: "
                f"its center is {gap:.3f} m from it and needs {radius:.3f} m"
            )
        for other in others:
            distance = pose.distance_to(self._poses[other])
            if distance < 2 * radius:
                raise PlacementError(
                    f"robot {index} at {where} would overlap robot {other}: {distance:.3f} m apart, "
                    f"{2 * radius:.3f} m needed"
                )

    @abstractmethod
    def _advance(self, speeds: Sequence[tuple[float, float]]) -> None:
        """Moves the bodies one tick; speeds: (left, right) rad/s of each robot's true wheels."""

    @abstractmethod
    def _read(self, index: int) -> Pose:
        """Where robot `index` is after the tick."""

    @abstractmethod
    def _put(self, index: int, pose: Pose) -> None:
        """Puts robot `index` at a pose, at rest."""

    @abstractmethod
    def _bodies(self) -> Any:
        """The physical state as plain data."""

    @abstractmethod
    def _restore_bodies(self, bodies: Any) -> None:
        """Sets the physical state."""
