"""Local exploration: drives over the rigid graph around a node, sampling places and views (section 3.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.compass import turn_between
from ..agent.goals import ExploreLocally, LocalSamples
from ..agent.local_pose import LocalPose
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.obstacle_memory import ObstacleMemory
from ..agent.rigid_graph import Cell, RigidGraph
from ..agent.wall_scan import WallScan
from ..world.robot import STOP, Image, Percept, WheelCommand, wrap_angle

Panorama = NDArray[np.float32]
_COMPASS, _PARALLAX = math.radians(0.7), math.radians(200.0)
"""Standard deviation of a turn by views: rad, and rad a meter between the places."""

_PATIENCE = 12
"""Retreats before obstacles after which exploration goes home."""


_BEHIND = -0.04
"""Places with x below it (m) have the wall at their side by which a convex corner was reached."""


@dataclass(frozen=True, slots=True)
class LocalExplorationConfig:
    """Settings of local exploration.

    rows, columns, spacing (m): the rigid graph. position_interval, panorama_interval (m): how far apart
    samples are taken. speed, turn_speed: steps/s. margin: free space (m) left between shell and obstacle
    where the robot goes; stop_margin: the same while driving, touch_margin: where it drove before. landmarks:
    whether walls swept while turning correct the pose, compass: whether views do (profile `thesis`: path
    integration alone). compass_views: so many nearest panoramas are compared, and the first, none farther
    than compass_range (m). approach: how far at most to drive toward a wall lost sight of (m).
    """

    rows: int = 5
    columns: int = 5
    spacing: float = 0.05
    position_interval: float = 0.02
    panorama_interval: float = 0.04
    speed: float = 233.0
    turn_speed: float = 300.0
    margin: float = 0.010
    stop_margin: float = 0.006
    touch_margin: float = 0.002
    approach: float = 0.06
    landmarks: bool = True
    compass: bool = True
    compass_views: int = 3
    compass_range: float = 0.015


class Exploring(Enum):
    """What local exploration is doing."""

    PLAN = "plan"
    AIM = "aim"
    DRIVE = "drive"
    RETREAT = "retreat"
    VIEW = "view"
    SCAN = "scan"
    APPROACH = "approach"
    SQUARE_UP = "square-up"


class LocalExploration(Behavior):
    """Explores the space around the node the robot stands at and comes back to it.

    Goal: `agent.goals.ExploreLocally`. Finishes with `LocalSamples` as result, standing at the node again
    with the heading it came with.
    """

    name = "local-exploration"
    priority = 40
    States = Exploring
    initial = Exploring.PLAN
    Config = LocalExplorationConfig
    transitions = (
        Transition("aim", (Exploring.PLAN, Exploring.VIEW), Exploring.AIM),
        Transition("go", Exploring.AIM, Exploring.DRIVE),
        Transition("blocked", (Exploring.AIM, Exploring.RETREAT), Exploring.PLAN),
        Transition("retreat", Exploring.DRIVE, Exploring.RETREAT),
        Transition("arrived", Exploring.DRIVE, Exploring.PLAN),
        Transition("view", (Exploring.DRIVE, Exploring.PLAN), Exploring.VIEW),
        Transition("plan", Exploring.VIEW, Exploring.PLAN),
        Transition("scan", Exploring.PLAN, Exploring.SCAN),
        Transition("scanned", Exploring.SCAN, Exploring.PLAN),
        Transition("nothing_seen", Exploring.SCAN, Exploring.APPROACH),
        Transition("near_enough", Exploring.APPROACH, Exploring.SCAN),
        Transition("home", Exploring.PLAN, Exploring.SQUARE_UP),
    )
    config: LocalExplorationConfig

    def on_reset(self) -> None:
        """Forgets the place it was exploring."""
        config = self.config
        self._rigid = RigidGraph(config.rows, config.columns, config.spacing)
        self._pose = LocalPose()
        self._here: Cell = self._rigid.center
        self._target: Cell | None = None
        self._queue: list[Cell] = []
        self._visited: set[Cell] = {self._here}
        self._given_up = 0
        self._scan: WallScan | None = None
        self._memory = ObstacleMemory()
        self._retreats = 0
        self._scanned = not config.landmarks
        self._look_behind = False
        self._wall_normal: float | None = None
        self._approached = 0.0
        self._facing = self._astray = False
        self._remaining = 0.0
        self._positions: list[tuple[float, float]] = []
        self._view_places: list[tuple[float, float]] = []
        self._view_variances: list[float] = []
        self._panoramas: list[Panorama] = []
        self._views: dict[int, Image] = {}
        self._headings: list[int] = []

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes an `ExploreLocally` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, ExploreLocally):
            raise TypeError(f"{self.name} needs an ExploreLocally goal, not {goal!r}")
        self._queue = self._rigid.order(goal.strategy)
        self._scan = WallScan(context.geometry)
        self._pose = LocalPose(goal.heading, goal.square)
        self._look_behind = goal.corner == "convex"
        self._wall_normal = goal.walls[0][0] if goal.walls else None
        for normal, distance, deviation in goal.walls:
            self._pose.know(normal, distance, deviation)
        for x, y in goal.points:
            self._memory.know(x, y)

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of exploring."""
        self._integrate(context)
        state = self.state
        if state is Exploring.PLAN:
            command = self._plan(context)
        elif state is Exploring.AIM:
            command = self._aim(percept, context)
        elif state is Exploring.DRIVE:
            command = self._drive(percept, context)
        elif state is Exploring.RETREAT:
            command = self._retreat(percept, context)
        elif state is Exploring.VIEW:
            command = self._view(percept, context)
        elif state is Exploring.SCAN:
            command = self._last_scan(percept, context)
        elif state is Exploring.APPROACH:
            command = self._approach(percept, context)
        else:
            command = self._square_up(context)
        return Proposal(command, 1.0, state.value)

    # --- states --------------------------------------------------------------------------------------

    def _plan(self, context: Context) -> WheelCommand:
        if self._view_is_due():
            self._begin_view()
            return STOP
        self._target = self._next_cell()
        if self._target is None and self._astray:
            self._astray = False
            self._target = self._here
        if self._target is not None:
            self.fire("aim")
        elif not self._scanned:
            self._begin_scan(context)
        else:
            self.fire("home")
        return STOP

    def _next_cell(self) -> Cell | None:
        """The next node to drive to, a neighbor of this one; None when home again."""
        if self._retreats > _PATIENCE:
            self._queue.clear()
        while self._queue:
            goal = self._queue[0]
            if goal in self._visited:
                self._queue.pop(0)
                continue
            path = self._rigid.path(self._here, goal)
            if path:
                return path[0]
            self._queue.pop(0)
            self._given_up += 1
        home = self._rigid.center if self._scanned else self._lookout()
        path = self._rigid.path(self._here, home) or self._rigid.way_back(self._here, home)
        return path[0] if path else None

    def _lookout(self) -> Cell:
        """Where to look at walls last: at the node if walls stand around it, else beside the wall behind."""
        if not self._look_behind or self._wall_normal is None:
            return self._rigid.center
        behind = [cell for cell in sorted(self._visited) if self._rigid.places[cell][0] < _BEHIND]
        sine = math.sin(self._wall_normal)
        return max(behind, key=lambda cell: self._rigid.places[cell][1] * sine, default=self._rigid.center)

    def _aim(self, percept: Percept, context: Context) -> WheelCommand:
        assert self._target is not None
        x, y, bearing = self._to(self._target)
        remaining = wrap_angle(bearing - self._pose.heading)
        if abs(remaining) > 0.006:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        if self._rigid.was_driven(self._here, self._target) or self._way_is_free(
            percept, context, math.hypot(x, y)
        ):
            self.fire("go")
        else:
            self._rigid.block(self._here, self._target)
            self.fire("blocked")
        return STOP

    def _way_is_free(self, percept: Percept, context: Context, way: float) -> bool:
        """Whether nothing sensed now, and nothing remembered, is in the way to the target."""
        assert self._target is not None
        geometry = context.geometry
        if not is_free(obstacles(percept, geometry), geometry, way, self.config.margin):
            return False
        clearance = geometry.body_radius + self.config.stop_margin
        start = (self._pose.x, self._pose.y)
        return not self._memory.blocks(start, self._rigid.places[self._target], clearance)

    def _drive(self, percept: Percept, context: Context) -> WheelCommand:
        assert self._target is not None
        x, y, bearing = self._to(self._target)
        error = wrap_angle(bearing - self._pose.heading)
        remaining = math.hypot(x, y) * math.cos(error)
        if remaining < 0.001:
            self._rigid.drove(self._here, self._target)
            self._here = self._target
            self._visited.add(self._target)
            self.fire("arrived")
            return STOP
        if self._view_is_due():
            self._begin_view()
            return STOP
        points = obstacles(percept, context.geometry)
        known = self._rigid.was_driven(self._here, self._target)
        margin = self.config.touch_margin if known else self.config.stop_margin
        if not is_free(points, context.geometry, min(remaining, 0.01), margin):
            self._rigid.block(self._here, self._target)
            self._retreats += 1
            self.fire("retreat")
            return STOP
        return drive_command(
            context.geometry, self._speed(remaining, context), 3.0 * max(-0.3, min(0.3, error))
        )

    def _retreat(self, percept: Percept, context: Context) -> WheelCommand:
        """Backwards, the way it came, to the node it left."""
        x, y, bearing = self._to(self._here)
        error = wrap_angle(bearing + math.pi - self._pose.heading)
        remaining = math.hypot(x, y) * math.cos(error)
        if remaining < 0.001:
            self.fire("blocked")
            return STOP
        speed = -self._speed(remaining, context)
        return drive_command(context.geometry, speed, 3.0 * max(-0.3, min(0.3, error)))

    def _view(self, percept: Percept, context: Context) -> WheelCommand:
        """Turns to the four directions of the local frame, one after the other, and looks."""
        if not self._headings:
            panorama = np.array([self._views[k] for k in range(4)], dtype=np.float32)
            self._views = {}
            self._correct(context)
            if self.config.compass:
                self._compare(panorama, context)
            self._panoramas.append(panorama)
            self._view_places.append((self._pose.x, self._pose.y))
            self._view_variances.append(self._pose.heading_variance)
            self.fire("plan" if self._target in (None, self._here) else "aim")
            return STOP
        self._sweep(percept)
        remaining = wrap_angle(0.5 * math.pi * self._headings[0] - self._pose.heading)
        if abs(remaining) > 0.004:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        self._views[self._headings.pop(0)] = context.look()
        return STOP

    def _begin_scan(self, context: Context) -> None:
        self._scan = WallScan(context.geometry)
        self._remaining = math.tau
        self.fire("scan")

    def _last_scan(self, percept: Percept, context: Context) -> WheelCommand:
        """One turn on the spot before going home, so that it gets home well."""
        self._sweep(percept)
        self._remaining -= context.turn
        if self._remaining > 0.01:
            return spin_command(context.geometry, self._remaining, self.config.turn_speed)
        seen = self._correct(context)
        lookout = not self._look_behind or self._here != self._rigid.center
        if not seen and lookout and self._wall_normal is not None and not self._astray:
            self._astray = True
            self.fire("nothing_seen")
            return STOP
        self._scanned = True
        self.fire("scanned")
        return STOP

    def _approach(self, percept: Percept, context: Context) -> WheelCommand:
        """Toward where the wall it came along must be, until it is near enough to be told from the noise."""
        assert self._wall_normal is not None
        error = wrap_angle(self._wall_normal - self._pose.heading)
        if not self._facing:
            self._facing = abs(error) <= 0.006
            return spin_command(context.geometry, error, self.config.turn_speed)
        self._approached += abs(context.distance)
        points = obstacles(percept, context.geometry)
        if self._approached >= self.config.approach or not is_free(points, context.geometry, 0.02, 0.005):
            self._scan = WallScan(context.geometry)
            self._remaining = math.tau
            self.fire("near_enough")
            return STOP
        return drive_command(context.geometry, self.config.speed, 3.0 * max(-0.3, min(0.3, error)))

    def _square_up(self, context: Context) -> WheelCommand:
        remaining = wrap_angle(-self._pose.heading)
        if abs(remaining) > 0.004:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        self.finish(True, f"{len(self._visited)} places, {self._given_up} given up", self._samples())
        return STOP

    # --- parts of states -----------------------------------------------------------------------------

    def _integrate(self, context: Context) -> None:
        self._pose.move(context.distance, context.turn)
        if self._due(self._positions, self.config.position_interval):
            self._positions.append((self._pose.x, self._pose.y))

    def _sweep(self, percept: Percept) -> None:
        if self.config.landmarks and self._scan is not None:
            self._scan.add(self._pose.heading, percept)
            self._memory.add(self._pose.pose, obstacles(percept, self._scan.geometry))

    def _correct(self, context: Context) -> bool:
        """Corrects the pose by the walls swept over in the turn that just ended; True if by a known one."""
        known = False
        if self.config.landmarks and self._scan is not None:
            for wall in self._scan.walls():
                known |= self._pose.see(wall)
        self._scan = WallScan(context.geometry)
        return known

    def _compare(self, panorama: Panorama, context: Context) -> None:
        """Corrects the heading by turning the panorama against the first and the nearest ones before it."""
        x, y = self._pose.x, self._pose.y
        away = [math.hypot(x - u, y - v) for u, v in self._view_places]
        near = sorted(range(len(away)), key=away.__getitem__)[: self.config.compass_views]
        for index in dict.fromkeys([0, *near] if away else []):
            if away[index] > self.config.compass_range:
                continue
            turn = turn_between(self._panoramas[index], panorama, context.geometry.camera_field_of_view)
            if turn is not None:
                deviation = _COMPASS + _PARALLAX * math.hypot(away[index], self._pose.place_deviation)
                self._pose.turn_by_compass(turn.angle, deviation**2 + self._view_variances[index])

    def _due(self, places: list[tuple[float, float]], interval: float) -> bool:
        if not places:
            return True
        x, y = places[-1]
        return math.hypot(self._pose.x - x, self._pose.y - y) >= interval

    def _view_is_due(self) -> bool:
        """Every panorama_interval, but not on the way home after the last scan: turning costs heading."""
        over = self.config.landmarks and self._scanned
        return not over and self._due(self._view_places, self.config.panorama_interval)

    def _begin_view(self) -> None:
        """Orders the four directions so that one sweep in place meets them all, the nearest first."""
        first = round(self._pose.heading / (0.5 * math.pi))
        turn = 1 if self._pose.heading >= 0.5 * math.pi * first else -1
        self._headings = [(first + turn * k) % 4 for k in range(4)]
        self.fire("view")

    def _to(self, cell: Cell) -> tuple[float, float, float]:
        """dx, dy (m) and bearing (rad, local frame) from the robot to a node of the rigid graph."""
        x, y = self._rigid.places[cell]
        dx, dy = x - self._pose.x, y - self._pose.y
        return dx, dy, math.atan2(dy, dx)

    def _speed(self, remaining: float, context: Context) -> float:
        """The set speed, less for the last tick's way."""
        last = remaining / (context.geometry.distance_per_step * 0.032)
        return min(self.config.speed, max(20.0, last))

    def _samples(self) -> LocalSamples:
        return LocalSamples(
            positions=np.array(self._positions, dtype=np.float64),
            panorama_positions=np.array(self._view_places, dtype=np.float64),
            panoramas=np.array(self._panoramas, dtype=np.float32),
            visited=len(self._visited),
            unreachable=self._given_up,
        )
