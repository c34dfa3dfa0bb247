"""Position correction by the wall: back off along the wall just followed and come to the corner again.

A corner met by following its wall is the same point within a millimeter, whatever error the exploration of
local space left; the thesis corrects by views alone (section 3.5.2), which is good for a centimeter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from ..agent.behavior import Behavior, Child, Context, Proposal, Transition
from ..agent.events import CornerReached, Event
from ..agent.goals import Follow, FollowFrom, ReacquireCorner
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.perception.side_view import SideView, WallFilter
from ..world.robot import STOP, Percept
from .wall_following import WallFollowing

_CORNER = 0.008
"""A hit of the diagonal sensor this near (m) to the wall ahead may be on it."""


_FAR = 0.065
"""Meters from the rim up to which the wall is still followed: exploration may have strayed from it."""
_LATE = 0.0018
"""Meters beyond a wall's end at which, so far out, it is noticed; 1 mm for the wall follower itself."""


_WELL_KNOWN, _ODD = 15, math.radians(6.0)
"""Lines of a wall after which its direction is known, and how far a later view may differ (rad)."""


@dataclass(frozen=True, slots=True)
class PositionCorrectionConfig:
    """Settings of the position correction.

    back_off: how far to go back along the wall at most (m). speed: steps/s. margin: free space (m) to leave
    behind.
    samples: ticks of standing still to measure the wall's direction. turn_speed: steps/s.
    tolerance: how much farther than expected the corner may be (m).
    """

    back_off: float = 0.14
    speed: float = 233.0
    turn_speed: float = 150.0
    margin: float = 0.008
    samples: int = 8
    tolerance: float = 0.06


class Correcting(Enum):
    """What the position correction is doing."""

    MEASURE = "measure"
    TURN = "turn"
    BACK = "back"
    MEASURE_AGAIN = "measure-again"
    TURN_AGAIN = "turn-again"
    FOLLOW = "follow"


class PositionCorrection(Behavior):
    """Comes to the corner again. Goal: `agent.goals.ReacquireCorner`. Result: the `CornerReached` heard."""

    name = "position-correction"
    priority = 30
    States = Correcting
    initial = Correcting.MEASURE
    Config = PositionCorrectionConfig
    transitions = (
        Transition("measured", Correcting.MEASURE, Correcting.TURN),
        Transition("back", (Correcting.MEASURE, Correcting.TURN), Correcting.BACK),
        Transition("far_enough", Correcting.BACK, Correcting.MEASURE_AGAIN),
        Transition("measured_again", Correcting.MEASURE_AGAIN, Correcting.TURN_AGAIN),
        Transition("follow", (Correcting.MEASURE_AGAIN, Correcting.TURN_AGAIN), Correcting.FOLLOW),
        Transition("try_again", Correcting.FOLLOW, Correcting.BACK, when="may_try_again"),
    )
    Goal = ReacquireCorner
    example = ReacquireCorner("right", "concave", 0.3)
    children: ClassVar = {
        "follower": Child(
            WallFollowing, angle_gain=3.0, distance_gain=60.0, lost_range=_FAR, advance_trim=_LATE
        )
    }
    config: PositionCorrectionConfig
    goal: ReacquireCorner
    follower: WallFollowing

    def on_reset(self) -> None:
        """Forgets the corner."""
        self._angles: list[float] = []
        self._ticks = 0
        self._remaining = 0.0
        self._backed = 0.0
        self._path = 0.0
        self._tries = 0
        self._wall = WallFilter(self.follower.config.distance, 0.0, 0.03)
        self._heard: CornerReached | None = None

    def on_start(self, context: Context) -> None:
        """Looks at the goal's side."""
        self._view = SideView(context.geometry, self.goal.side)

    def on_child_event(self, child: Behavior, event: Event, context: Context) -> None:
        """Keeps the corners to itself: they are not new ones."""
        if isinstance(event, CornerReached):
            self._heard = event

    def on_tick(self, percept: Percept, context: Context) -> None:
        """Takes in what the sensors at the side say."""
        self._view.read(percept)

    def measure(self, percept: Percept, context: Context) -> Proposal:
        """Stands and averages the direction of the wall at the side, if it sees one."""
        if self._has_measured(seen=self.goal.kind != "convex"):
            angle = self._mean_angle()
            self._remaining = -self._view.sign * (angle or 0.0)
            self.fire("back" if angle is None else "measured")
        return self.proposal(STOP)

    def turn(self, percept: Percept, context: Context) -> Proposal:
        """Turns parallel to the wall."""
        return self._turn(context, then="back")

    def back(self, percept: Percept, context: Context) -> Proposal:
        """Backwards along the wall, keeping its distance where it is seen and the heading where it is not."""
        geometry, view, wall = context.geometry, self._view, self._wall
        self._backed -= context.distance
        wall.predict(context.distance, context.turn * view.sign)
        line = self._side_wall(view)
        if line is not None:
            wall.correct(line)
        unseen = self.follower.config.distance if self.goal.kind == "convex" else 0.0
        room = min(self.config.back_off + unseen, self.goal.room)
        blocked = not is_free(obstacles(percept, geometry), geometry, -0.01, self.config.margin)
        if self._backed - self._path >= room or blocked:
            self.fire("far_enough")
            return self.proposal(STOP)
        slant = max(-0.2, min(0.2, 6.0 * (wall.distance - self.follower.config.distance)))
        turn_rate = 3.0 * max(-0.3, min(0.3, slant - wall.angle))
        return self.proposal(drive_command(geometry, -self.config.speed, turn_rate * view.sign))

    def measure_again(self, percept: Percept, context: Context) -> Proposal:
        """The same as at first, farther back, where the wall is well in view."""
        if self._has_measured(seen=True):
            angle = self._mean_angle()
            if angle is None:
                self.fire("follow")
                return self.proposal(STOP)
            if self._wall.samples >= _WELL_KNOWN and abs(angle - self._wall.angle) > _ODD:
                # Part of a sensor's cone misses the wall here; on the way back it was seen well.
                angle = self._wall.angle
            self._remaining = -self._view.sign * angle
            self.fire("measured_again")
        return self.proposal(STOP)

    def turn_again(self, percept: Percept, context: Context) -> Proposal:
        """Turns parallel to the wall."""
        return self._turn(context, then="follow")

    def on_enter_follow(self, context: Context) -> None:
        """Begins at the wall, or before it where it is not seen yet."""
        beside = self._view.side < self.follower.config.lost_range
        start = FollowFrom.WALL if beside else FollowFrom.GAP
        self.follower.start(Follow(self.goal.side, start), context)
        if beside and self._view.side_wall() is None:
            self.follower.expect(context.geometry.body_radius + self._view.side)

    def follow(self, percept: Percept, context: Context) -> Proposal | None:
        """Follows the wall to its corner, and judges whether it is the one."""
        self._path += context.distance
        proposal = self.follower.propose(percept, context)
        corner = self._heard
        if corner is not None:
            self._heard = None
            if corner.kind == self.goal.kind and abs(self._path - self._backed) <= self.config.tolerance:
                self.finish(True, f"at the {corner.kind} corner again", corner)
                return Proposal(STOP, 1.0, "arrived")
            if corner.kind == self.goal.kind and self.may_try_again():
                return self._try_again()
            self.finish(False, f"met a {corner.kind} corner after {self._path:.3f} m instead", corner)
            return Proposal(STOP, 1.0, "another corner")
        if self._path > self._backed + self.config.tolerance:
            self.finish(False, f"no corner within {self._path:.3f} m", None)
            return Proposal(STOP, 1.0, "no corner")
        return proposal

    def may_try_again(self) -> bool:
        """Whether it has not backed off a second time yet."""
        return self._tries == 0

    def _try_again(self) -> Proposal:
        """The wall was lost, not at its end: backs off once more, with what following has learned of it."""
        skew = self._view.sign * self.follower.skew
        self._wall = WallFilter(self.follower.config.distance, skew, 0.1)
        self.fire("try_again")
        self._tries += 1
        return Proposal(STOP, 1.0, "once more")

    def _has_measured(self, seen: bool) -> bool:
        """Takes one more look at the wall at the side, if it can be `seen`; whether that is enough."""
        wall = self._side_wall(self._view)
        self._ticks += 1
        if wall is not None and seen and abs(wall[1]) < math.radians(25.0):
            self._angles.append(wall[1])
        return self._ticks >= self.config.samples

    def _mean_angle(self) -> float | None:
        """The wall's direction (rad), None if it was seen too seldom. The next measurement begins."""
        angles, self._angles, self._ticks = self._angles, [], 0
        return sum(angles) / len(angles) if len(angles) >= max(1, self.config.samples // 2) else None

    def _side_wall(self, view: SideView) -> tuple[float, float] | None:
        """The wall at the side; None where the diagonal sensor hits the wall ahead, as in a corner."""
        wall, front = view.side_wall(), view.front_wall()
        if wall is None or front is None:
            return wall
        geometry = view.geometry
        ahead = (geometry.body_radius + view.diagonal) * math.cos(geometry.infrared_angles[1])
        return wall if ahead < front[0] - _CORNER else None

    def _turn(self, context: Context, then: str) -> Proposal:
        self._remaining -= context.turn
        if abs(self._remaining) > 0.004:
            return self.proposal(spin_command(context.geometry, self._remaining, self.config.turn_speed))
        self.fire(then)
        return self.proposal(STOP)
