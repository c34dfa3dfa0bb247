"""What all simulated worlds share: robots with noisy wheels and sensors, time, placing, state.

A subclass moves the bodies (`_advance`, `_read`, `_put`); everything a robot senses is computed here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

from ..errors import PlacementError, SimulationError, WorldError
from ..geometry import Clearing
from ..noise.random_streams import Streams
from ..robot import CONTROL_PERIOD, Pose, RobotGeometry
from ..sensors.sensor import Mounting
from ..sensors.surroundings import Surroundings
from ..spec import WorldSpec
from .simulated_robot import SimulatedRobot

if TYPE_CHECKING:
    from ..noise.model import Noise
    from ..sensors.registry import Fitted

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
        seed: int,
        noise: Noise,
        sensors: Fitted,
        geometry: RobotGeometry,
        rays: str,
    ) -> None:
        """Prepares one robot for each of `starts` and what is around them; bodies are the subclass's.

        Raises: PlacementError when a start overlaps something.
        """
        self._tick, self._open = 0, True
        self.spec = spec
        self.seed = seed
        self.geometry = geometry
        self.noise = noise
        self.surroundings = Surroundings(spec, starts, geometry, rays)
        touch = geometry.body_radius + TOUCH
        self._clearings = [Clearing(self.surroundings.plan, touch, LOOK_AHEAD) for _ in starts]
        for index, pose in enumerate(starts):
            self._check_place(pose, index, range(index))
        self.robots: list[SimulatedRobot] = [
            SimulatedRobot(Mounting(index, geometry, self.surroundings, noise, Streams(seed, index)), sensors)
            for index in range(len(starts))
        ]
        for robot, pose in zip(self.robots, starts, strict=True):
            robot.start(0, 0.0, pose)

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return self._tick * CONTROL_PERIOD

    def step(self) -> None:
        """See `base.World.step`."""
        if not self._open:
            raise WorldError(f"world {self.spec.name!r} is closed")
        self._advance([robot.wheel_speeds() for robot in self.robots])
        self._tick += 1
        self.surroundings.robots = [
            self._checked(self._read(index), index) for index in range(len(self.robots))
        ]
        for index, robot in enumerate(self.robots):
            pose = self.surroundings.robots[index]
            if self._touching(pose, index):
                robot.collisions += 1
            robot.tick(self._tick, self.time, pose)

    def true_pose(self, robot: int = 0) -> Pose:
        """See `base.World.true_pose`."""
        return self.surroundings.robots[robot]

    def collisions(self, robot: int = 0) -> int:
        """See `base.World.collisions`."""
        return self.robots[robot].collisions

    def clearance(self, x: float, y: float) -> float:
        """See `base.World.clearance`."""
        return self.surroundings.plan.clearance(x, y)

    def place(self, pose: Pose, robot: int = 0) -> None:
        """See `base.World.place`."""
        self._check_place(pose, robot, [index for index in range(len(self.robots)) if index != robot])
        self.surroundings.robots[robot] = pose
        self._put(robot, pose)
        self.robots[robot].start(self._tick, self.time, pose)

    def state(self) -> dict[str, Any]:
        """See `base.World.state`."""
        return {
            "version": STATE_VERSION,
            "kind": self.kind,
            "world": self.spec.digest,
            "tick": self._tick,
            "poses": [[pose.x, pose.y, pose.heading] for pose in self.surroundings.robots],
            "movable": [[pose.x, pose.y, pose.heading] for pose in self.surroundings.boxes],
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
        self.surroundings.robots = [Pose(*map(float, pose)) for pose in state["poses"]]
        self.surroundings.boxes = [Pose(*map(float, pose)) for pose in state["movable"]]
        self._restore_bodies(state["bodies"])
        for robot, saved in zip(self.robots, state["robots"], strict=True):
            robot.restore(saved)

    def close(self) -> None:
        """See `base.World.close`."""
        self._open = False

    def __enter__(self) -> Self:
        """The world itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes it."""
        self.close()

    def __repr__(self) -> str:
        """The world's name, how many robots, what simulates them, and the time."""
        count = len(self.surroundings.robots)
        robots = f"{count} robot{'s' if count > 1 else ''}"
        kind, closed = self.kind.replace("-", " "), "" if self._open else ", closed"
        return f"World({self.spec.name!r}, {robots}, {kind}, t={self.time:.1f} s{closed})"

    def _touching(self, pose: Pose, index: int) -> bool:
        clearing = self._clearings[index]
        if not (clearing.holds(pose.x, pose.y) or clearing.renew(pose.x, pose.y)):
            return True
        if self.surroundings.alone:
            return False
        return bool(self.surroundings.moving_gaps(index, pose.x, pose.y, self.geometry.body_radius + TOUCH))

    def _checked(self, pose: Pose, index: int) -> Pose:
        if not (abs(pose.x) < FAR_AWAY and abs(pose.y) < FAR_AWAY and math.isfinite(pose.heading)):
            raise SimulationError(f"robot {index} is at {pose} after {self.time:.3f} s: the run ends")
        return pose

    def _check_place(self, pose: Pose, index: int, others: Iterable[int]) -> None:
        where = f"robot {index} at ({pose.x:.3f}, {pose.y:.3f}) in world {self.spec.name!r}"
        if not (abs(pose.x) < FAR_AWAY and abs(pose.y) < FAR_AWAY and math.isfinite(pose.heading)):
            raise PlacementError(f"{where}: a start must be finite and within {FAR_AWAY:g} m")
        radius = self.geometry.body_radius
        gap = self.surroundings.plan.clearance(pose.x, pose.y)
        if gap < radius:
            raise PlacementError(
                f"{where} would overlap a wall: its center is {gap:.3f} m from it and needs {radius:.3f} m"
            )
        for other in others:
            distance = pose.distance_to(self.surroundings.robots[other])
            if distance < 2 * radius:
                raise PlacementError(
                    f"{where} would overlap robot {other}: {distance:.3f} m apart, {2 * radius:.3f} m needed"
                )
        if self.surroundings.box_gaps(pose.x, pose.y, radius):
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
