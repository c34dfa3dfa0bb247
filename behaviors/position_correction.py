"""Position correction by the wall: back off along the wall just followed and come to the corner again.

A corner met by following its wall is the same point within a millimeter, whatever error the exploration of
local space left; the thesis corrects by views alone (section 3.5.2), which is good for a centimeter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.events import CornerReached, Event
from ..agent.goals import Follow, FollowFrom, ReacquireCorner
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.perception.side_view import SideView, WallFilter
from ..world.robot import STOP, Percept, WheelCommand
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
        Transition("try_again", Correcting.FOLLOW, Correcting.BACK),
    )
    config: PositionCorrectionConfig

    def on_reset(self) -> None:
        """Forgets the corner."""
        self._goal: ReacquireCorner | None = None
        self._view: SideView | None = None
        self._angles: list[float] = []
        self._ticks = 0
        self._remaining = 0.0
        self._backed = 0.0
        self._path = 0.0
        self._again = False
        self._follower = WallFollowing(
            angle_gain=3.0, distance_gain=60.0, lost_range=_FAR, advance_trim=_LATE
        )
        self._follower.emit = self._hear  # type: ignore[method-assign]
        self._wall = WallFilter(self._follower.config.distance, 0.0, 0.03)
        self._heard: CornerReached | None = None

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes a `ReacquireCorner` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, ReacquireCorner):
            raise TypeError(f"{self.name} needs a ReacquireCorner goal, not {goal!r}")
        self._goal = goal
        self._view = SideView(context.geometry, goal.side)

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of correcting."""
        assert self._view is not None
        self._view.read(percept)
        state = self.state
        if state is Correcting.MEASURE or state is Correcting.MEASURE_AGAIN:
            command = self._measure(context)
        elif state is Correcting.TURN or state is Correcting.TURN_AGAIN:
            command = self._turn(context)
        elif state is Correcting.BACK:
            command = self._back(percept, context)
        else:
            return self._follow(percept, context)
        return Proposal(command, 1.0, state.value)

    def _measure(self, context: Context) -> WheelCommand:
        """Stands and averages the direction of the wall at the side, if it sees one."""
        assert self._view is not None
        again = self.state is Correcting.MEASURE_AGAIN
        wall = self._side_wall(self._view)
        self._ticks += 1
        hidden = not again and self._goal is not None and self._goal.kind == "convex"
        if wall is not None and not hidden and abs(wall[1]) < math.radians(25.0):
            self._angles.append(wall[1])
        if self._ticks < self.config.samples:
            return STOP
        seen = len(self._angles) >= self.config.samples // 2
        mean = sum(self._angles) / len(self._angles) if seen else 0.0
        if again and self._wall.samples >= _WELL_KNOWN and abs(mean - self._wall.angle) > _ODD:
            # Part of a sensor's cone misses the wall here; on the way back it was seen well.
            mean = self._wall.angle
        self._remaining = -self._view.sign * mean
        self._angles.clear()
        self._ticks = 0
        if again:
            self.fire("measured_again" if seen else "follow")
            if not seen:
                self._begin_follow(context)
        else:
            self.fire("measured" if seen else "back")
        return STOP

    def _side_wall(self, view: SideView) -> tuple[float, float] | None:
        """The wall at the side; None where the diagonal sensor hits the wall ahead, as in a corner."""
        wall, front = view.side_wall(), view.front_wall()
        if wall is None or front is None:
            return wall
        geometry = view.geometry
        ahead = (geometry.body_radius + view.diagonal) * math.cos(geometry.infrared_angles[1])
        return wall if ahead < front[0] - _CORNER else None

    def _turn(self, context: Context) -> WheelCommand:
        self._remaining -= context.turn
        if abs(self._remaining) > 0.004:
            return spin_command(context.geometry, self._remaining, self.config.turn_speed)
        if self.state is Correcting.TURN:
            self.fire("back")
        else:
            self.fire("follow")
            self._begin_follow(context)
        return STOP

    def _back(self, percept: Percept, context: Context) -> WheelCommand:
        """Backwards along the wall, keeping its distance where it is seen and the heading where it is not."""
        assert self._goal is not None
        assert self._view is not None
        geometry, view, wall = context.geometry, self._view, self._wall
        self._backed -= context.distance
        wall.predict(context.distance, context.turn * view.sign)
        line = self._side_wall(view)
        if line is not None:
            wall.correct(line)
        unseen = self._follower.config.distance if self._goal.kind == "convex" else 0.0
        room = min(self.config.back_off + unseen, self._goal.room)
        blocked = not is_free(obstacles(percept, geometry), geometry, -0.01, self.config.margin)
        if self._backed - self._path >= room or blocked:
            self.fire("far_enough")
            return STOP
        slant = max(-0.2, min(0.2, 6.0 * (wall.distance - self._follower.config.distance)))
        turn_rate = 3.0 * max(-0.3, min(0.3, slant - wall.angle))
        return drive_command(geometry, -self.config.speed, turn_rate * view.sign)

    def _begin_follow(self, context: Context) -> None:
        assert self._goal is not None
        self._follower.reset()
        beside = self._view is not None and self._view.side < self._follower.config.lost_range
        start = FollowFrom.WALL if beside else FollowFrom.GAP
        self._follower.on_start(Follow(self._goal.side, start), context)
        if beside and self._view is not None and self._view.side_wall() is None:
            self._follower.expect(context.geometry.body_radius + self._view.side)

    def _follow(self, percept: Percept, context: Context) -> Proposal:
        assert self._goal is not None
        self._path += context.distance
        proposal = self._follower.propose(percept, context)
        corner = self._heard
        if corner is not None:
            self._heard = None
            if corner.kind == self._goal.kind and abs(self._path - self._backed) <= self.config.tolerance:
                self.finish(True, f"at the {corner.kind} corner again", corner)
                return Proposal(STOP, 1.0, "arrived")
            if corner.kind == self._goal.kind and not self._again:
                return self._try_again()
            self.finish(False, f"met a {corner.kind} corner after {self._path:.3f} m instead", corner)
            return Proposal(STOP, 1.0, "another corner")
        if self._path > self._backed + self.config.tolerance:
            self.finish(False, f"no corner within {self._path:.3f} m", None)
            return Proposal(STOP, 1.0, "no corner")
        return proposal

    def _try_again(self) -> Proposal:
        """The wall was lost, not at its end: backs off once more, with what following has learned of it."""
        self._again = True
        skew = (self._view.sign if self._view is not None else 1.0) * self._follower.skew
        self._wall = WallFilter(self._follower.config.distance, skew, 0.1)
        self.fire("try_again")
        return Proposal(STOP, 1.0, "once more")

    def _hear(self, event: Event, context: Context) -> None:
        if isinstance(event, CornerReached):
            self._heard = event
