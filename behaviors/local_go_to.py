"""Local navigation: drives from place to place in a local map (section 3.5.3), its pose kept by the walls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.estimation.landmarks import SHORT_SWEEP, LandmarkFix
from ..agent.estimation.local_filter import LocalPose
from ..agent.goals import DrivePath, PlacesDriven
from ..agent.local_goals import DrivePathWithLandmarks, PlacesByWalls
from ..agent.motion import drive_command, is_free, obstacles, shy_turn, spin_command
from ..world.robot import STOP, Percept, Pose, RobotGeometry, WheelCommand, wrap_angle


@dataclass(frozen=True, slots=True)
class LocalGoToConfig:
    """Settings of local navigation.

    speed, turn_speed: steps/s; fix_speed: the same while it turns to and fro for the walls. margin: free
    space (m) between shell and obstacle.
    """

    speed: float = 233.0
    turn_speed: float = 450.0
    fix_speed: float = 150.0
    margin: float = 0.006


class LocalGoing(Enum):
    """What local navigation is doing."""

    AIM = "aim"
    DRIVE = "drive"
    RETREAT = "retreat"
    FACE = "face"
    FIX = "fix"
    FACE_AGAIN = "face-again"


class LocalGoTo(Behavior):
    """Drives through places of a local map. Goal: `agent.goals.DrivePath`. Result: `PlacesDriven`.

    With a goal `agent.local_goals.DrivePathWithLandmarks` the walls that its turns sweep correct the pose,
    and the result is `PlacesByWalls`.

    An obstacle on the way: it goes back to the place before and gives up, so that the caller can remember the
    blocked edge and plan anew.
    """

    name = "local-go-to"
    priority = 40
    States = LocalGoing
    initial = LocalGoing.AIM
    Config = LocalGoToConfig
    transitions = (
        Transition("go", LocalGoing.AIM, LocalGoing.DRIVE),
        Transition("next", LocalGoing.DRIVE, LocalGoing.AIM),
        Transition("retreat", LocalGoing.DRIVE, LocalGoing.RETREAT),
        Transition("face", LocalGoing.AIM, LocalGoing.FACE),
        Transition("fix", LocalGoing.FACE, LocalGoing.FIX),
        Transition("fixed", LocalGoing.FIX, LocalGoing.FACE_AGAIN),
    )
    config: LocalGoToConfig

    def on_reset(self) -> None:
        """Forgets the places."""
        self._by_walls = self._fix_at_end = False
        self._heading: float | None = None
        self._places: list[tuple[float, float]] = []
        self._reached = 0
        self._from = (0.0, 0.0)
        self._pose = LocalPose()
        self._fix = LandmarkFix(RobotGeometry(), self._pose, landmarks=False)

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes a `DrivePath` or `DrivePathWithLandmarks` goal. Raises: TypeError for anything else."""
        if isinstance(goal, DrivePathWithLandmarks):
            self._pose = LocalPose.of(goal.belief)
            self._fix_at_end = goal.fix
        elif isinstance(goal, DrivePath):
            self._pose = LocalPose(goal.start[2])
            self._pose.x, self._pose.y = goal.start[:2]
        else:
            raise TypeError(f"{self.name} needs a DrivePath goal or DrivePathWithLandmarks, not {goal!r}")
        self._by_walls = isinstance(goal, DrivePathWithLandmarks)
        self._places = list(goal.places)
        self._heading = goal.heading
        self._fix = LandmarkFix(context.geometry, self._pose, landmarks=self._by_walls)
        self._from = (self._pose.x, self._pose.y)

    @property
    def pose(self) -> Pose:
        """Where it holds the robot to be (m, rad), in the frame of the places."""
        return self._pose.pose

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of local navigation."""
        self._fix.integrate(context)
        if self.state is LocalGoing.AIM:
            command = self._aim(percept, context)
        elif self.state is LocalGoing.DRIVE:
            command = self._drive(percept, context)
        elif self.state is LocalGoing.RETREAT:
            command = self._retreat(context)
        elif self.state is LocalGoing.FIX:
            command = self._take_fix(percept, context)
        else:
            command = self._face(percept, context)
        return Proposal(command, 1.0, self.state.value)

    def _aim(self, percept: Percept, context: Context) -> WheelCommand:
        if not self._places:
            self.fire("face")
            return STOP
        self._fix.sweep(percept)
        length, bearing = self._to(self._places[0])
        if length < 0.002:
            self._arrive()
            return STOP
        remaining = wrap_angle(bearing - self._pose.heading)
        if abs(remaining) > 0.006:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        self._fix.correct()
        if not is_free(obstacles(percept, context.geometry), context.geometry, length, self.config.margin):
            self._end(False, f"the way to place {self._reached} is blocked")
            return STOP
        self.fire("go")
        return STOP

    def _drive(self, percept: Percept, context: Context) -> WheelCommand:
        length, bearing = self._to(self._places[0])
        error = wrap_angle(bearing - self._pose.heading)
        remaining = length * math.cos(error)
        if remaining < 0.001:
            self._arrive()
            self.fire("next")
            return STOP
        points = obstacles(percept, context.geometry)
        if not is_free(points, context.geometry, min(remaining, 0.01), self.config.margin):
            self.fire("retreat")
            return STOP
        last = remaining / (context.geometry.distance_per_step * 0.032)
        turn_rate = 3.0 * error + shy_turn(points, context.geometry)
        return drive_command(context.geometry, min(self.config.speed, max(20.0, last)), turn_rate)

    def _retreat(self, context: Context) -> WheelCommand:
        length, bearing = self._to(self._from)
        error = wrap_angle(bearing + math.pi - self._pose.heading)
        if length * math.cos(error) < 0.001:
            self._end(False, f"an obstacle on the way to place {self._reached}")
            return STOP
        return drive_command(context.geometry, -self.config.speed, 3.0 * max(-0.3, min(0.3, error)))

    def _face(self, percept: Percept, context: Context) -> WheelCommand:
        heading, again = self._heading, self.state is LocalGoing.FACE_AGAIN
        if heading is not None:
            self._fix.sweep(percept)
            remaining = wrap_angle(heading - self._pose.heading)
            if abs(remaining) > 0.004:
                speed = self.config.fix_speed if again else self.config.turn_speed
                return spin_command(context.geometry, remaining, speed)
        if self._fix_at_end and not again:
            turn = self._fix.turn_to_see() if heading is None else 0.0
            self._fix.begin((turn, *SHORT_SWEEP))
            self.fire("fix")
        else:
            self._end(True, "arrived")
        return STOP

    def _take_fix(self, percept: Percept, context: Context) -> WheelCommand:
        command = self._fix.fix(percept, context, self.config.fix_speed)
        if command is not None:
            return command
        self._fix.correct()
        self.fire("fixed")
        return STOP

    def _arrive(self) -> None:
        self._from = self._places.pop(0)
        self._reached += 1
        self._fix.forget()

    def _to(self, place: tuple[float, float]) -> tuple[float, float]:
        dx, dy = place[0] - self._pose.x, place[1] - self._pose.y
        return math.hypot(dx, dy), math.atan2(dy, dx)

    def _end(self, succeeded: bool, reason: str) -> None:
        pose = self._pose
        result: Any = PlacesDriven(self._reached, pose.pose)
        if self._by_walls:
            result = PlacesByWalls(self._reached, pose.pose, pose.belief())
        self.finish(succeeded, reason, result)
