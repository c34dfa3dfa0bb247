"""Crossings from node to node: along a wall, straight across open space, along the next to its corner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

from ...world.robot import Pose, wrap_angle
from ..boundary.trace import BEND
from ..events import BehaviorFinished, CornerReached, WallMet
from ..goals import Crossing, Follow, FollowFrom, Foray
from ..listener import Listener, Outcome

if TYPE_CHECKING:
    from ..agent import Agent


@dataclass(frozen=True, slots=True)
class CrossingGates:
    """How far a crossing may be from what was expected and still be the same.

    distance, join: m, each plus slope x the distance across. wall: rad.
    """

    distance: float = 0.06
    join: float = 0.08
    slope: float = 0.06
    wall: float = 0.5

    def misfit(self, expected: Crossing, driven: Crossing) -> str:
        """What speaks against it, in words; nothing if nothing does."""
        slack = self.slope * expected.distance
        if abs(driven.distance - expected.distance) > self.distance + slack:
            return f"a wall after {driven.distance:.2f} m, not {expected.distance:.2f} m"
        turned = wrap_angle(driven.wall - expected.wall)
        if abs(turned) > self.wall:
            return f"a wall that stands {math.degrees(turned):.0f} deg off"
        if abs(driven.join - expected.join) > self.join + slack:
            return f"its corner after {driven.join:.2f} m, not {expected.join:.2f} m"
        return ""


class Stage(Enum):
    """What a crossing is doing."""

    IDLE = "idle"
    ALONG = "along the wall"
    ACROSS = "across"
    JOIN = "along the wall met"


class CrossingDrive(Listener):
    """Drives crossings, one at a time, by the behaviors `wall-following` and `foray`.

    One that succeeds has as its result what was driven, a `Crossing`, and the `CornerReached` at its end.
    on_landed: called with the distance driven across (m) when a wall is met; the robot then follows it.
    """

    def __init__(
        self,
        agent: Agent,
        side: str,
        on_end: Callable[[Outcome], None],
        on_landed: Callable[[float], None] = lambda distance: None,
    ) -> None:
        """side: of the wall that is followed before and after."""
        super().__init__(agent, on_end)
        self.agent, self.side = agent, side
        self.stage = Stage.IDLE
        self._on_landed = on_landed
        self._goal = Crossing(0.0, 0.0, 0.0, 0.0, 0.0)
        self._pose: Pose | None = None
        self._distance = self._most = self._bent = 0.0
        self._heading = 0.0
        self._wall: float | None = None
        self._since = -math.inf
        self.listen(BehaviorFinished, self._on_finished)
        self.listen(WallMet, self._on_wall)
        self.listen(CornerReached, self._on_corner)

    def begin(
        self,
        goal: Crossing,
        start: FollowFrom,
        bend: float | None,
        *,
        pose: Pose | None = None,
        most: float | None = None,
    ) -> None:
        """Sets out from a node, standing there in its transition pose.

        start, bend: what the robot stands at, as for `Follow`. goal.offset 0: straight from the node, `turn`
        then being from its entry heading. pose: of the point where it leaves the wall, heading along it; then
        path integration starts afresh from there. most: m across until it gives up; None is a little more
        than expected.
        """
        self.start()
        self._goal, self._pose, self._wall = goal, pose, None
        self._most = 1.15 * goal.distance + 0.15 if most is None else most
        self._since = self.agent.context.time
        if goal.offset > 0.0:
            self.stage = Stage.ALONG
            self.agent.start("wall-following", Follow(self.side, start, bend, goal.offset))
        else:
            self._cross(0.0)

    def cross(self, turn: float, most: float) -> None:
        """Sets out across from where the robot stands. turn: from its own heading (rad). most: m."""
        self.begin(Crossing(0.0, turn, most, 0.0, 0.0), FollowFrom.WALL, None, most=most)

    def join(self) -> None:
        """Only the last part: looks for a wall ahead and follows it to its corner."""
        self.start()
        self._join()

    def _join(self) -> None:
        self.stage, self._wall, self._bent = Stage.JOIN, None, 0.0
        self._since = self.agent.context.time
        self.agent.start("wall-following", Follow(self.side))

    def release(self) -> None:
        """Ends it; the robot goes on along the wall it has met."""
        super().stop("released")
        self.stage = Stage.IDLE

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it where the robot is, if it is under way."""
        if self.stage is not Stage.IDLE:
            super().stop(reason)
            self._halt()

    def _halt(self) -> None:
        self.stage = Stage.IDLE
        for name in ("wall-following", "foray"):
            self.agent.stop(name)

    def _cross(self, skew: float) -> None:
        odometry, pose = self.agent.odometry, self._pose
        if pose is not None:
            odometry.reset(Pose(pose.x, pose.y, pose.heading + skew))
        self.stage = Stage.ACROSS
        turn = wrap_angle(self._goal.turn - skew)
        self._heading = odometry.heading + turn
        self.agent.start("foray", Foray(turn, self._most))

    def _on_finished(self, event: BehaviorFinished) -> None:
        if self.stage is Stage.ALONG and event.behavior == "wall-following":
            self._cross(float(event.result or 0.0))
        elif self.stage is Stage.ACROSS and event.behavior == "foray":
            self._distance = float(event.result or 0.0)
            if not event.succeeded:
                self._fail(event.reason)
                return
            self._join()
            self._on_landed(self._distance)

    def _on_wall(self, event: WallMet) -> None:
        if self.stage is Stage.JOIN and event.time > self._since:
            self._wall = event.heading

    def _on_corner(self, event: CornerReached) -> None:
        if event.time <= self._since:
            return  # of what was driven before: whoever began this crossing heard it first
        if self.stage is Stage.ALONG and event.kind != BEND:
            self._fail(f"met a {event.kind} corner before {self._goal.offset:.2f} m")
        elif self.stage is Stage.JOIN and event.kind == BEND:
            self._bent += event.path_length
        elif self.stage is Stage.JOIN:
            self.stage = Stage.IDLE
            self.agent.stop("wall-following")
            wall = event.heading if self._wall is None else self._wall
            driven = Crossing(
                self._goal.offset,
                self._goal.turn,
                self._distance,
                wrap_angle(wall - self._heading),
                self._bent + event.path_length,
            )
            self.finish(True, (driven, event))

    def _fail(self, reason: str) -> None:
        self._halt()
        self.finish(False, reason=reason)
