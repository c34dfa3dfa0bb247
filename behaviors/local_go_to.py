"""Local navigation: drives from place to place in a local map by path integration (section 3.5.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import GoThrough, PlacesDriven
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..world.robot import STOP, Percept, Pose, WheelCommand, wrap_angle


@dataclass(frozen=True, slots=True)
class LocalGoToConfig:
    """Settings of local navigation. speeds: steps/s. margin: free space (m) between shell and obstacle."""

    speed: float = 233.0
    turn_speed: float = 233.0
    margin: float = 0.006


class LocalGoing(Enum):
    """What local navigation is doing."""

    AIM = "aim"
    DRIVE = "drive"
    RETREAT = "retreat"
    FACE = "face"


class LocalGoTo(Behavior):
    """Drives through places of a local map. Goal: `agent.goals.GoThrough`. Result: `PlacesDriven`.

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
    )
    config: LocalGoToConfig

    def on_reset(self) -> None:
        """Forgets the places."""
        self._places: list[tuple[float, float]] = []
        self._reached = 0
        self._from = (0.0, 0.0)
        self._heading: float | None = None
        self.pose = Pose()

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes a `GoThrough` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, GoThrough):
            raise TypeError(f"{self.name} needs a GoThrough goal, not {goal!r}")
        self._places = list(goal.places)
        self._heading = goal.heading
        self.pose = Pose(*goal.start)
        self._from = goal.start[:2]

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of local navigation."""
        self._integrate(context)
        if self.state is LocalGoing.AIM:
            command = self._aim(percept, context)
        elif self.state is LocalGoing.DRIVE:
            command = self._drive(percept, context)
        elif self.state is LocalGoing.RETREAT:
            command = self._retreat(context)
        else:
            command = self._face(context)
        return Proposal(command, 1.0, self.state.value)

    def _aim(self, percept: Percept, context: Context) -> WheelCommand:
        if not self._places:
            self.fire("face")
            return STOP
        length, bearing = self._to(self._places[0])
        if length < 0.002:
            self._arrive()
            return STOP
        remaining = wrap_angle(bearing - self.pose.heading)
        if abs(remaining) > 0.006:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        if not is_free(obstacles(percept, context.geometry), context.geometry, length, self.config.margin):
            self.finish(
                False, f"the way to place {self._reached} is blocked", PlacesDriven(self._reached, self.pose)
            )
            return STOP
        self.fire("go")
        return STOP

    def _drive(self, percept: Percept, context: Context) -> WheelCommand:
        length, bearing = self._to(self._places[0])
        error = wrap_angle(bearing - self.pose.heading)
        remaining = length * math.cos(error)
        if remaining < 0.001:
            self._arrive()
            self.fire("next")
            return STOP
        if not is_free(
            obstacles(percept, context.geometry), context.geometry, min(remaining, 0.01), self.config.margin
        ):
            self.fire("retreat")
            return STOP
        last = remaining / (context.geometry.distance_per_step * 0.032)
        return drive_command(context.geometry, min(self.config.speed, max(20.0, last)), 3.0 * error)

    def _retreat(self, context: Context) -> WheelCommand:
        length, bearing = self._to(self._from)
        error = wrap_angle(bearing + math.pi - self.pose.heading)
        if length * math.cos(error) < 0.001:
            self.finish(
                False,
                f"an obstacle on the way to place {self._reached}",
                PlacesDriven(self._reached, self.pose),
            )
            return STOP
        return drive_command(context.geometry, -self.config.speed, 3.0 * max(-0.3, min(0.3, error)))

    def _face(self, context: Context) -> WheelCommand:
        if self._heading is not None:
            remaining = wrap_angle(self._heading - self.pose.heading)
            if abs(remaining) > 0.004:
                return spin_command(context.geometry, remaining, self.config.turn_speed)
        self.finish(True, "arrived", PlacesDriven(self._reached, self.pose))
        return STOP

    def _arrive(self) -> None:
        self._from = self._places.pop(0)
        self._reached += 1

    def _to(self, place: tuple[float, float]) -> tuple[float, float]:
        dx, dy = place[0] - self.pose.x, place[1] - self.pose.y
        return math.hypot(dx, dy), math.atan2(dy, dx)

    def _integrate(self, context: Context) -> None:
        pose = self.pose
        middle = pose.heading + 0.5 * context.turn
        self.pose = Pose(
            pose.x + context.distance * math.cos(middle),
            pose.y + context.distance * math.sin(middle),
            pose.heading + context.turn,
        )
