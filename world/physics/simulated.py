"""What all simulated worlds share: robots with noisy wheels and sensors, time, placing, state.

A subclass moves the bodies (`_advance`, `_read`, `_put`); everything a robot senses is computed here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..errors import PlacementError, SimulationError, WorldError
from ..geometry import Clearing, Plan
from ..noise.model import Noise
from ..robot import CONTROL_PERIOD, EPUCK, Image, Pose, RobotGeometry
from ..sensors.dynamic_obstacles import Moving
from ..sensors.epuck import SimulatedRobot
from ..sensors.infrared import InfraredModel
from ..sensors.infrared_rays import InfraredCaster
from ..sensors.sensing import Sensing
from ..sensors.views import Views
from ..spec import WorldSpec

TOUCH = 5e-5
"""The shell counts as touching below this distance (m)."""
LOOK_AHEAD = 0.03
"""How far (m) beyond its shell the walls around a robot are looked at, so that not every tick need do it."""
STATE_VERSION = 1
FAR_AWAY = 1e4
"""Coordinates (m) beyond which a run is given up, and where nothing can be placed."""


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
        sensing: Sensing | None = None,
        geometry: RobotGeometry = EPUCK,
        rays: str = "auto",
    ) -> None:
        """Prepares sensing and one robot for each of `starts`; bodies are the subclass's.

        Raises: PlacementError when a start overlaps something.
        """
        self.spec = spec
        self.seed = seed
        self.geometry = geometry
        self.noise = noise or Noise()
        self._plan = Plan(spec.shapes)
        self._infrared = InfraredModel(geometry)
        lowest = min((shape.height for shape in spec.shapes), default=1.0)
        self._seen = (
            self._plan
            if lowest >= self._infrared.height
            else Plan(spec.shapes, min_height=self._infrared.height)
        )
        self._caster = InfraredCaster(self._infrared, spec.shapes, rays) if rays != "auto" else None
        touch = geometry.body_radius + TOUCH
        self._clearings = [Clearing(self._plan, touch, LOOK_AHEAD) for _ in starts]
        self._tick = 0
        self._open = True
        self._poses = list(starts)
        self._movable_poses = [Pose(item.box.x, item.box.y, item.box.angle) for item in spec.movable]
        self._moving = Moving(geometry, spec.movable, len(starts))
        self._views = Views(geometry, spec, self._moving, rays)
        for index, pose in enumerate(starts):
            self._check_place(pose, index, range(index))
        sensing = sensing or Sensing()
        self.robots: list[SimulatedRobot] = [
            SimulatedRobot(self, index, geometry, self.noise, sensing, seed) for index in range(len(starts))
        ]
        for robot, pose in zip(self.robots, starts, strict=True):
            robot.start(0, 0.0, pose)

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
        self._poses = [self._checked(self._read(index), index) for index in range(len(self.robots))]
        for index, robot in enumerate(self.robots):
            pose = self._poses[index]
            if self._touching(pose, index):
                robot.collisions += 1
            robot.tick(self._tick, self.time, pose)

    def true_pose(self, robot: int = 0) -> Pose:
        """See `base.World.true_pose`."""
        return self._poses[robot]

    def movable_pose(self, index: int) -> Pose:
        """Where a movable box really is: its center and heading (m, rad)."""
        return self._movable_poses[index]

    def collisions(self, robot: int = 0) -> int:
        """See `base.World.collisions`."""
        return self.robots[robot].collisions

    def clearance(self, x: float, y: float) -> float:
        """See `base.World.clearance`."""
        return self._plan.clearance(x, y)

    def place(self, pose: Pose, robot: int = 0) -> None:
        """See `base.World.place`."""
        self._check_place(pose, robot, [index for index in range(len(self.robots)) if index != robot])
        self._poses[robot] = pose
        self._put(robot, pose)
        self.robots[robot].start(self._tick, self.time, pose)

    def state(self) -> dict[str, Any]:
        """See `base.World.state`."""
        return {
            "version": STATE_VERSION,
            "kind": self.kind,
            "world": self.spec.digest,
            "tick": self._tick,
            "poses": [[pose.x, pose.y, pose.heading] for pose in self._poses],
            "movable": [[pose.x, pose.y, pose.heading] for pose in self._movable_poses],
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
        try:
            self._restore(state)
        except (KeyError, TypeError, IndexError, ValueError) as error:
            raise WorldError(f"this state of world {self.spec.name!r} is damaged: {error!r}") from None

    def _restore(self, state: Mapping[str, Any]) -> None:
        self._tick = int(state["tick"])
        self._poses = [Pose(*map(float, pose)) for pose in state["poses"]]
        self._movable_poses = [Pose(*map(float, pose)) for pose in state["movable"]]
        self._restore_bodies(state["bodies"])
        for robot, saved in zip(self.robots, state["robots"], strict=True):
            robot.restore(saved)

    def close(self) -> None:
        """See `base.World.close`."""
        self._open = False

    def infrared_values(self, index: int, pose: Pose) -> list[float]:
        """Noise-free raw values of one robot's eight sensors at a pose."""
        moving = (
            self._moving.edges_near(index, pose, self._poses, self._movable_poses, self._infrared)
            if self._moving.count > 1
            else []
        )
        if self._caster is None:
            fixed = self._seen.edges_near(pose.x, pose.y, self._infrared.reach)
            return self._infrared.read(pose, fixed + moving if moving else fixed)
        distances = self._caster.distances(pose)
        if moving:
            others = self._infrared.distances(pose, moving)
            distances = [min(pair) for pair in zip(distances, others, strict=True)]
        return self._infrared.values(distances)

    def infrared_model(self) -> InfraredModel:
        """The response of the infrared sensors."""
        return self._infrared

    def render(self, index: int, pose: Pose, width: int, height: int) -> Image:
        """What one robot's camera sees from a pose, without noise."""
        return self._views.render(index, pose, self._poses, self._movable_poses, width, height)

    def _touching(self, pose: Pose, index: int) -> bool:
        clearing = self._clearings[index]
        if not (clearing.holds(pose.x, pose.y) or clearing.renew(pose.x, pose.y)):
            return True
        if self._moving.count == 1:
            return False
        reach = self.geometry.body_radius + TOUCH
        return bool(self._moving.gaps(pose.x, pose.y, reach, index, self._poses, self._movable_poses))

    def _checked(self, pose: Pose, index: int) -> Pose:
        if not (abs(pose.x) < FAR_AWAY and abs(pose.y) < FAR_AWAY and math.isfinite(pose.heading)):
            raise SimulationError(f"robot {index} is at {pose} after {self.time:.3f} s: the run ends")
        return pose

    def _check_place(self, pose: Pose, index: int, others: Iterable[int]) -> None:
        where = f"robot {index} at ({pose.x:.3f}, {pose.y:.3f}) in world {self.spec.name!r}"
        if not (abs(pose.x) < FAR_AWAY and abs(pose.y) < FAR_AWAY and math.isfinite(pose.heading)):
            raise PlacementError(f"{where}: a start must be finite and within {FAR_AWAY:g} m")
        radius = self.geometry.body_radius
        gap = self._plan.clearance(pose.x, pose.y)
        if gap < radius:
            raise PlacementError(
                f"{where} would overlap a wall: its center is {gap:.3f} m from it and needs {radius:.3f} m"
            )
        for other in others:
            distance = pose.distance_to(self._poses[other])
            if distance < 2 * radius:
                raise PlacementError(
                    f"{where} would overlap robot {other}: {distance:.3f} m apart, {2 * radius:.3f} m needed"
                )
        if self._moving.box_gaps(pose.x, pose.y, radius, self._movable_poses):
            raise PlacementError(f"{where} would overlap a movable box: it needs {radius:.3f} m")

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
