"""Local navigation: drives from place to place in a local map (section 3.5.3), its pose kept by the walls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.estimation.landmarks import SHORT_SWEEP, LandmarkFix
from ..agent.estimation.local_filter import LocalPose
from ..agent.goals import DrivePath, PlacesDriven
from ..agent.motion import drive_command, is_free, obstacles, shy_turn, spin_command
from ..world.robot import CONTROL_PERIOD, STOP, Percept, Pose, wrap_angle


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

    Where the goal has a belief, the walls that its turns sweep correct the pose, and the result has one too.

    An obstacle on the way: it goes back to the place before and gives up, so that the caller can remember the
    blocked edge and plan again.
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
    Goal = DrivePath
    example = DrivePath(((0.05, 0.0), (0.05, 0.05)))
    config: LocalGoToConfig
    goal: DrivePath

    def on_reset(self) -> None:
        """Forgets the places."""
        self._places: list[tuple[float, float]] = []
        self._reached = 0
        self._pose = LocalPose()

    def on_start(self, context: Context) -> None:
        """Takes places and pose from the goal."""
        goal = self.goal
        if goal.belief is not None:
            self._pose = LocalPose.of(goal.belief)
        else:
            self._pose = LocalPose(goal.start[2])
            self._pose.x, self._pose.y = goal.start[:2]
        self._places = list(goal.places)
        self._fix = LandmarkFix(context.geometry, self._pose, landmarks=goal.belief is not None)
        self._from = (self._pose.x, self._pose.y)

    @property
    def pose(self) -> Pose:
        """Where it holds the robot to be (m, rad), in the frame of the places."""
        return self._pose.pose

    def on_tick(self, percept: Percept, context: Context) -> None:
        """Keeps the pose."""
        self._fix.integrate(context)

    def aim(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the next place, and makes sure that the way there is free."""
        if not self._places:
            self.fire("face")
            return self.proposal(STOP)
        self._fix.sweep(percept)
        length, bearing = self._to(self._places[0])
        if length < 0.002:
            self._arrive()
            return self.proposal(STOP)
        remaining = wrap_angle(bearing - self._pose.heading)
        if abs(remaining) > 0.006:
            return self._spin(remaining, self.config.turn_speed, context)
        self._fix.correct()
        if not is_free(obstacles(percept, context.geometry), context.geometry, length, self.config.margin):
            self._end(False, f"the way to place {self._reached} is blocked")
            return self.proposal(STOP)
        self.fire("go")
        return self.proposal(STOP)

    def drive(self, percept: Percept, context: Context) -> Proposal:
        """Drives to the place, steering by the pose."""
        length, bearing = self._to(self._places[0])
        error = wrap_angle(bearing - self._pose.heading)
        remaining = length * math.cos(error)
        if remaining < 0.001:
            self._arrive()
            self.fire("next")
            return self.proposal(STOP)
        points = obstacles(percept, context.geometry)
        if not is_free(points, context.geometry, min(remaining, 0.01), self.config.margin):
            self.fire("retreat")
            return self.proposal(STOP)
        last = remaining / (context.geometry.distance_per_step * CONTROL_PERIOD)
        turn_rate = 3.0 * error + shy_turn(points, context.geometry)
        speed = min(self.config.speed, max(20.0, last))
        return self.proposal(drive_command(context.geometry, speed, turn_rate))

    def retreat(self, percept: Percept, context: Context) -> Proposal:
        """Backs to the place before."""
        length, bearing = self._to(self._from)
        error = wrap_angle(bearing + math.pi - self._pose.heading)
        if length * math.cos(error) < 0.001:
            self._end(False, f"an obstacle on the way to place {self._reached}")
            return self.proposal(STOP)
        turn_rate = 3.0 * max(-0.3, min(0.3, error))
        return self.proposal(drive_command(context.geometry, -self.config.speed, turn_rate))

    def face(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the heading that was asked for; then looks for the walls, if that was asked for too."""
        if remaining := self._to_face(percept):
            return self._spin(remaining, self.config.turn_speed, context)
        if self.goal.fix:
            turn = self._fix.turn_to_see() if self.goal.heading is None else 0.0
            self._fix.begin((turn, *SHORT_SWEEP))
            self.fire("fix")
        else:
            self._end(True, "arrived")
        return self.proposal(STOP)

    def fix(self, percept: Percept, context: Context) -> Proposal:
        """Turns to and fro for the walls."""
        command = self._fix.fix(percept, context, self.config.fix_speed)
        if command is not None:
            return self.proposal(command)
        self._fix.correct()
        self.fire("fixed")
        return self.proposal(STOP)

    def face_again(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the heading by what the walls told."""
        if remaining := self._to_face(percept):
            return self._spin(remaining, self.config.fix_speed, context)
        self._end(True, "arrived")
        return self.proposal(STOP)

    def _to_face(self, percept: Percept) -> float:
        """What there is still to turn (rad), 0 if it faces the heading or none was asked for."""
        if self.goal.heading is None:
            return 0.0
        self._fix.sweep(percept)
        remaining = wrap_angle(self.goal.heading - self._pose.heading)
        return remaining if abs(remaining) > 0.004 else 0.0

    def _spin(self, remaining: float, speed: float, context: Context) -> Proposal:
        return self.proposal(spin_command(context.geometry, remaining, speed))

    def _arrive(self) -> None:
        self._from = self._places.pop(0)
        self._reached += 1
        self._fix.forget()

    def _to(self, place: tuple[float, float]) -> tuple[float, float]:
        dx, dy = place[0] - self._pose.x, place[1] - self._pose.y
        return math.hypot(dx, dy), math.atan2(dy, dx)

    def _end(self, succeeded: bool, reason: str) -> None:
        belief = self._pose.belief() if self.goal.belief is not None else None
        self.finish(succeeded, reason, PlacesDriven(self._reached, self._pose.pose, belief))
