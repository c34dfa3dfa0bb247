"""Wall following with corners as explicit states (profile `default`).

Follows a wall at a set distance; stops at each corner, says so, and turns around it in place, so that the
corner is the same point of space from either direction: at `distance` from both walls. Chapter 3.4.1 traces
boundaries by a weighted sum of the infrared values instead: see `reactive_wall_following`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.boundary.trace import BEND
from ..agent.events import CornerReached, Event, WallMet
from ..agent.goals import Follow, FollowFrom
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.perception.side_view import SideView, WallCourse
from ..agent.perception.wall_filter import SideWall
from ..world.robot import STOP, Percept, WheelCommand, wrap_angle

_PARALLEL = 5
"""Lines of a wall after which its direction is known to a robot that began beside it."""
_UNSEEN = 0.004
"""Meters without a sight of the wall's direction after which it has ended."""
_TURNED = 0.02
"""Standard deviation (rad) of a wall's direction after a turn, if no line of it is seen: a thin one's end."""
_AROUND = math.radians(100.0)
"""How far a convex corner is turned around at once: after more, the way would lead over its edge."""
_OPENING = 0.04
"""Meters past a wall's end at which the robot, turned around it, would just not touch it."""
_BLUNT = math.radians(60.0)
"""A wall ahead that turns by less, right behind a convex corner, is the one that was to be turned to."""
_SHY_TURN = 1.0
"""Turn rate (rad/s) away from what is nearly touched."""


@dataclass(frozen=True, slots=True)
class WallFollowingConfig:
    """Settings of wall following.

    distance: robot's center to the wall (m). speed: while following, steps/s (233 is 3 cm/s). blind_speed:
    the same where nothing tells the wall's direction, before a convex corner: the encoders err less the
    slower they count, and the heading at the corner is what they make of it.
    turn_speed: of each wheel in a turn in place, steps/s. angle_gain: 1/s, distance_gain: rad/(s m).
    lost_range: the side sensor sees no wall beyond it (m from the rim). advance_trim: how much of
    `distance` the robot has driven past the wall's end when it notices (m). gap_limit: how far to drive
    after a convex corner until the next wall must be at the side (m). settle: how much of a wall (m) tells
    its direction. intrusion: what juts out of the wall by more (m) is kept away from at once;
    what comes nearer than shy (m from the rim) is turned away from. bend: how far (rad) a wall turns without
    a corner before that is told.
    """

    distance: float = 0.057
    speed: float = 233.0
    blind_speed: float = 117.0
    turn_speed: float = 233.0
    angle_gain: float = 1.5
    distance_gain: float = 12.0
    lost_range: float = 0.05
    advance_trim: float = 0.001
    gap_limit: float = 0.14
    settle: float = 0.03
    intrusion: float = 0.01
    shy: float = 0.010
    bend: float = math.pi / 3.0


class Following(Enum):
    """What the wall follower is doing."""

    SEARCH = "search"
    FOLLOW = "follow"
    CONCAVE = "concave"
    ADVANCE = "advance"
    CONVEX = "convex"
    GAP = "gap"


class WallFollowing(Behavior):
    """Keeps a wall at one side, corner by corner. Goal: `agent.goals.Follow`.

    Finishes only beside a wall, having driven the goal's `reach`. Result: its heading from the wall (rad).
    """

    name = "wall-following"
    priority = 10
    States = Following
    initial = Following.SEARCH
    Config = WallFollowingConfig
    transitions = (
        Transition("found_wall", (Following.SEARCH, Following.CONCAVE, Following.GAP), Following.FOLLOW),
        Transition("wall_ahead", (Following.FOLLOW, Following.ADVANCE, Following.GAP), Following.CONCAVE),
        Transition("meet_wall", Following.SEARCH, Following.CONCAVE),
        Transition("wall_ended", Following.FOLLOW, Following.ADVANCE),
        Transition("around", Following.ADVANCE, Following.CONVEX),
        Transition("turned", Following.CONVEX, Following.GAP),
        Transition("turn_more", Following.GAP, Following.CONVEX),
        Transition("begin_concave", Following.SEARCH, Following.CONCAVE),
        Transition("begin_convex", Following.SEARCH, Following.CONVEX),
        Transition("begin_gap", Following.SEARCH, Following.GAP),
    )
    config: WallFollowingConfig

    def on_reset(self) -> None:
        """Forgets the wall."""
        self._view: SideView | None = None
        self._side = "right"
        self._reach: float | None = None
        self._wall = SideWall(self.config.distance)
        self._path = self._seen = 0.0
        self._leg = 0.0
        self._misses = 0
        self._remaining = 0.0
        self._sharper = 0.0
        self._edge, self._past = 0.5 * math.pi, self.config.distance
        self._turned = 0.0
        self._searching = self._swung = self._rounding = False
        self._settled = self._beside = False
        self._course = WallCourse()
        self._front: list[float] = []

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes a `Follow` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, Follow):
            raise TypeError(f"{self.name} needs a Follow goal, not {goal!r}")
        self._side, self._reach = goal.side, goal.reach
        self._view = SideView(context.geometry, goal.side)
        turn = 0.5 * math.pi if goal.turn is None else abs(goal.turn)
        if goal.start is FollowFrom.WALL:
            self._beside = True
            self.fire("found_wall")
        elif goal.start is FollowFrom.GAP:
            self.fire("begin_gap")
        elif goal.start is FollowFrom.CONCAVE:
            self._remaining = turn
            self.fire("begin_concave")
        elif goal.start is FollowFrom.CONVEX:
            self._remaining = -turn
            if turn > _AROUND:
                self._remaining, self._sharper = -0.5 * math.pi, turn - 0.5 * math.pi
            self.fire("begin_convex")

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of following."""
        view = self._view
        if view is None:
            raise TypeError(f"{self.name} was asked before it was given a Follow goal")
        view.read(percept)
        turned = context.turn * view.sign
        self._wall.predict(context.distance, turned)
        state = self.state
        if state is Following.FOLLOW:
            command = self._follow(view, context)
        elif state is Following.CONCAVE or state is Following.CONVEX:
            command = self._turn(turned, view)
        elif state is Following.ADVANCE:
            command = self._advance(view, context)
        elif state is Following.GAP:
            command = self._gap(view, context)
        else:
            command = self._search(view, percept)
        return Proposal(command, 1.0, state.value)

    def emit(self, event: Event, context: Context) -> None:
        """Publishes an event. A behavior that drives by this one replaces it to hear the corners first."""
        context.publish(event)

    @property
    def path(self) -> float:
        """Meters driven since the start or the last corner, turns in place not counted."""
        return self._path

    def expect(self, distance: float) -> None:
        """Tells how far (m) the robot's center is from the wall, where that is not the set distance."""
        self._wall = SideWall(distance, 0.0, 0.1)

    @property
    def skew(self) -> float:
        """The robot's heading (rad, counter-clockwise) from the direction of the wall it follows."""
        return (self._view.sign if self._view is not None else 1.0) * self._wall.angle

    # --- states --------------------------------------------------------------------------------------

    def _search(self, view: SideView, percept: Percept) -> WheelCommand:
        """Straight on until a wall is near, ahead or at a slant; then away from it."""
        geometry, front = view.geometry, view.front_wall()
        room = self.config.distance - geometry.body_radius - 0.002
        if not is_free(obstacles(percept, geometry), geometry, 0.01, room):
            self._remaining = front[1] if front is not None else 0.5 * math.pi
            self._searching = True
            self.fire("meet_wall")
            return STOP
        wall = view.side_wall()
        if wall is not None and wall[0] < self.config.distance + 0.02:
            self._meet(wall)
            self.fire("found_wall")
        return self._drive(0.0)

    def _follow(self, view: SideView, context: Context) -> WheelCommand:
        config = self.config
        self._count(context)
        self._settle(context)
        if self._reach is not None and self._path >= self._reach:
            self.finish(True, "followed as far as asked", self.skew)
            return STOP
        self._trace_course(context)
        if self._at_front(view, context, view.slanted_wall(self._wall.distance, self._wall.angle)):
            return STOP
        if view.side > config.lost_range:
            self._misses += 1
            if self._misses >= 2:
                self._end_of_wall(context)
            return self._drive(-config.angle_gain * self._wall.angle)
        self._misses = 0
        reach = context.geometry.body_radius + view.side
        if self._wall.sweep(view.hits(), reach) or self._wall.see(
            view.side_wall(), reach, view.near < math.inf
        ):
            self._seen = self._path
        return self._keep(view, reach)

    def _keep(self, view: SideView, abreast: float) -> WheelCommand:
        """Keeps the wall's distance; `abreast` (m) is that of what is beside the robot now, wall or not."""
        config, wall = self.config, self._wall
        if min(view.side, view.diagonal) < config.shy:
            return self._drive(_SHY_TURN)
        distance = wall.distance
        if abreast < config.distance - config.intrusion:
            # Something juts out that the filter does not know of: away from it first.
            distance = min(distance, abreast)
        error = max(-0.02, min(0.02, distance - config.distance))
        around = wall.bend * config.speed * view.geometry.distance_per_step
        return self._drive(-(config.angle_gain * wall.angle + config.distance_gain * error + around))

    def _advance(self, view: SideView, context: Context) -> WheelCommand:
        self._count(context)
        opening = self._leg >= _OPENING and view.side > self.config.lost_range
        if opening and self._is_at_front(view.front_wall()):
            # Across is the other wall of a passage: too narrow to pass its mouth, wide enough to enter.
            return self._around(context)
        if self._at_front(view, context):
            return STOP
        self._leg += context.distance
        if self._leg >= self._past:
            return self._around(context)
        if min(view.side, view.diagonal) < self.config.shy:  # an edge that was met askew
            return self._drive(_SHY_TURN)
        return self._drive(-self.config.angle_gain * self._wall.angle)

    def _end_of_wall(self, context: Context) -> None:
        """The corner is as far from the wall beyond as from this one; a right angle unless that was seen."""
        config = self.config
        self._leg, self._past, self._edge = (
            context.distance,
            config.distance - config.advance_trim,
            0.5 * math.pi,
        )
        edge = self._wall.edge()
        if edge is not None:
            self._edge, self._leg = edge
            self._past = config.distance * math.tan(0.5 * self._edge)
        self.fire("wall_ended")

    def _around(self, context: Context) -> WheelCommand:
        """Turns around the wall's end."""
        self._remaining = -self._edge - self._wall.angle
        self.fire("around")
        self._arrive("convex", context)
        return STOP

    def _gap(self, view: SideView, context: Context) -> WheelCommand:
        self._count(context)
        self._leg += context.distance
        if self._at_front(view, context):
            return STOP
        if self._sharper > 0.0:
            # From there the rest of the turn leads along the next wall, at the set distance.
            past = (1.0 - math.cos(self._sharper) + math.sin(self._sharper)) / math.sin(self._sharper)
            if self._leg > past * self.config.distance:
                self._remaining, self._sharper = -self._sharper, 0.0
                self.fire("turn_more")
        elif view.side < self.config.lost_range:
            self._misses += 1
            if self._misses >= 2:
                wall = view.side_wall()
                if wall is not None:
                    self._meet(wall)
                else:
                    self._wall = SideWall(context.geometry.body_radius + view.side, 0.0, _TURNED)
                self._misses = 0
                self._leg = 0.0
                self.fire("found_wall")
        else:
            self._misses = 0
            if self._leg > self.config.gap_limit:
                self._remaining = -0.25 * math.pi
                self._leg = 0.0
                self.fire("turn_more")
        return self._drive(-self.config.angle_gain * self._wall.angle)

    def _turn(self, turned: float, view: SideView) -> WheelCommand:
        self._remaining -= turned
        self._turned += turned
        if abs(self._remaining) > 0.004 and not self._parallel_already(view):
            return self._spin(self._remaining)
        self._turned = 0.0
        self._swung = self.state is Following.CONCAVE
        self._rounding = self.state is Following.CONVEX
        self._leg = 0.0
        self._misses = 0
        self._front.clear()
        self._wall = SideWall(self.config.distance, 0.0, 0.05)
        self.fire("turned" if self.state is Following.CONVEX else "found_wall")
        return STOP

    def _parallel_already(self, view: SideView) -> bool:
        """Whether, turning away from a wall ahead, it is at the side long before expected: it stood askew."""
        if self.state is not Following.CONCAVE or self._turned < 0.3 or self._remaining < 0.25:
            return False
        wall = view.side_wall()
        if wall is None or view.front_wall() is not None:
            return False
        return wall[1] > -0.02 and wall[0] < self.config.distance + 0.015

    # --- parts of states -----------------------------------------------------------------------------

    def _at_front(self, view: SideView, context: Context, slanted: tuple[float, float] | None = None) -> bool:
        """Stops for a wall ahead: looks a few ticks, standing, to learn where it lies, then turns."""
        front = slanted or view.front_wall()
        if front is None or not self._is_at_front(front):
            self._front.clear()
            return False
        self._front.append(front[1])
        if len(self._front) < 4:
            return True
        self._remaining = sum(self._front) / len(self._front)
        across = 0.5 * math.pi - self._wall.angle
        if abs(self._remaining - across) < 0.14:
            self._remaining = across
        self._front.clear()
        self.fire("wall_ahead")
        if not self._still_turning():
            self._arrive("concave", context)
        return True

    def _is_at_front(self, front: tuple[float, float] | None) -> bool:
        return front is not None and front[0] <= self.config.distance + 0.0005

    def _still_turning(self) -> bool:
        """Whether the wall ahead is the one just turned away from, and that was not enough; or turned to, and
        that was too much, as around a blunt corner.
        """
        if self._rounding and self._remaining < _BLUNT:
            return True
        askew = abs(self._remaining - 0.5 * math.pi) > 0.3
        return self._swung and self._path < 0.01 and (self._searching or askew)

    def _meet(self, wall: tuple[float, float]) -> None:
        self._wall.meet(wall)
        self._misses = 0

    def _count(self, context: Context) -> None:
        self._path += context.distance

    def _arrive(self, kind: str, context: Context) -> None:
        """Says that a corner is reached, with the direction of the wall just followed."""
        self._publish_wall(context)
        self._settled = self._searching = self._beside = False
        self._tell(kind, self._remaining, context)

    def _tell(self, kind: str, remaining: float, context: Context) -> None:
        path, self._path = self._path, 0.0
        blind, self._seen = path - self._seen, 0.0
        course, self._course = self._course, WallCourse()
        self.emit(
            CornerReached(
                time=context.time,
                side=self._side,
                kind=kind,
                path_length=path,
                heading=self._wall_direction(context),
                turn=remaining * (self._view.sign if self._view is not None else 1.0),
                max_heading_change=course.max_heading_change,
                unobserved_length=blind,
            ),
            context,
        )

    def _settle(self, context: Context) -> None:
        """Once enough of the new wall was followed, says where it leads."""
        self._leg += context.distance
        if not self._settled and self._leg >= self.config.settle and self._wall.samples >= 20:
            self._publish_wall(context)

    def _trace_course(self, context: Context) -> None:
        """Keeps where the wall leads, and tells when it has turned far without a corner."""
        known = self._settled or (self._beside and self._wall.samples >= _PARALLEL)
        if not known or not self._course.take(self._path, self._wall_direction(context)):
            return
        if abs(self._course.swing) >= self.config.bend:
            self._tell(BEND, 0.0, context)
            self._settled, self._beside, self._swung = False, True, False

    def _publish_wall(self, context: Context) -> None:
        if not self._settled:
            self._settled, self._rounding = True, False
            heading = self._wall_direction(context)
            self.emit(
                WallMet(time=context.time, side=self._side, heading=heading, path_length=self._path), context
            )

    def _wall_direction(self, context: Context) -> float:
        sign = self._view.sign if self._view is not None else 1.0
        return wrap_angle(context.pose.heading - sign * self._wall.angle)

    def _drive(self, turn_rate: float) -> WheelCommand:
        """Forward while turning at `turn_rate` (rad/s at the set speed, away from the wall is positive)."""
        assert self._view is not None
        # Not along a wall whose direction was never seen, such as a thin one's end.
        ending = self._seen > 0.0 and self.state in (Following.FOLLOW, Following.ADVANCE)
        blind = ending and self._path - self._seen > _UNSEEN
        speed = self.config.blind_speed if blind else self.config.speed
        # Slower along the same way: as much turn in a meter.
        turn_rate *= self._view.sign * speed / self.config.speed
        return drive_command(self._view.geometry, speed, turn_rate)

    def _spin(self, remaining: float) -> WheelCommand:
        """A turn in place by at most `remaining` (rad, away from the wall is positive) in this tick."""
        assert self._view is not None
        return spin_command(self._view.geometry, remaining * self._view.sign, self.config.turn_speed)
