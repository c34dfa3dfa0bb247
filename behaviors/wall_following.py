"""Wall following with corners as explicit states (profile `default`).

Follows a wall at a set distance; stops at each corner, says so, and turns around it in place, so that the
corner is the same point of space from either direction: at `distance` from both walls. Chapter 3.4.1 traces
boundaries by a weighted sum of the infrared values instead: see `reactive_wall_following`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.boundary.trace import BEND
from ..agent.events import CornerReached, WallMet
from ..agent.goals import Follow, FollowFrom
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.perception.side_view import SideView, WallCourse
from ..agent.perception.wall_filter import SideWall
from ..agent.walls import WALL_DISTANCE
from ..world.robot import STOP, Percept, wrap_angle

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

    distance: float = WALL_DISTANCE
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
    """What the wall follower is doing.

    SEARCH: looking for a wall. FOLLOW: beside it. CONCAVE: at a corner, turning away from the wall ahead;
    TURN_AWAY: the same where that is no corner, or one that was told before. ADVANCE: past the wall's end.
    CONVEX: at that corner, turning around it; TURN_TOWARD: turning farther. EDGE: passing the edge of a
    corner that is turned around in two parts. GAP: looking for the wall beyond.
    """

    SEARCH = "search"
    FOLLOW = "follow"
    CONCAVE = "concave"
    TURN_AWAY = "turn away"
    ADVANCE = "advance"
    CONVEX = "convex"
    TURN_TOWARD = "turn toward"
    EDGE = "edge"
    GAP = "gap"


class Known(Enum):
    """What is known of the wall at hand.

    NEW: nothing. BESIDE: the robot began parallel to it, or it has bent since it was told. SEARCHED: the
    robot turned away from it when the search met it. TURNED, ROUNDED: after a concave or a convex corner.
    TOLD: its direction is known and published.
    """

    NEW = "new"
    BESIDE = "beside"
    SEARCHED = "searched"
    TURNED = "turned"
    ROUNDED = "rounded"
    TOLD = "told"


_ALONG = (Following.FOLLOW, Following.ADVANCE, Following.EDGE, Following.GAP)


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
        Transition(
            "found_wall",
            (Following.SEARCH, Following.CONCAVE, Following.TURN_AWAY, Following.GAP),
            Following.FOLLOW,
        ),
        Transition("wall_ahead", _ALONG, Following.TURN_AWAY, when="is_still_turning"),
        Transition("wall_ahead", _ALONG, Following.CONCAVE),
        Transition("meet_wall", Following.SEARCH, Following.TURN_AWAY),
        Transition("wall_ended", Following.FOLLOW, Following.ADVANCE),
        Transition("around", Following.ADVANCE, Following.CONVEX),
        Transition("turned", (Following.CONVEX, Following.TURN_TOWARD), Following.EDGE, when="is_sharp"),
        Transition("turned", (Following.CONVEX, Following.TURN_TOWARD), Following.GAP),
        Transition("turn_more", (Following.EDGE, Following.GAP), Following.TURN_TOWARD),
        Transition("begin_concave", Following.SEARCH, Following.TURN_AWAY),
        Transition("begin_convex", Following.SEARCH, Following.TURN_TOWARD),
        Transition("begin_gap", Following.SEARCH, Following.GAP),
    )
    Goal = Follow
    example = Follow("right")
    config: WallFollowingConfig
    goal: Follow

    def on_reset(self) -> None:
        """Forgets the wall."""
        self._wall = SideWall(self.config.distance)
        self._known = Known.NEW
        self._course = WallCourse()
        self._path = self._seen = self._leg = 0.0
        self._misses = 0
        self._front: list[float] = []
        self._remaining = self._turned = self._sharper = 0.0
        self._edge, self._past = 0.5 * math.pi, self.config.distance

    def on_start(self, context: Context) -> None:
        """Goes to the state that the goal's `start` says."""
        goal = self.goal
        self._view = SideView(context.geometry, goal.side)
        turn = 0.5 * math.pi if goal.turn is None else abs(goal.turn)
        if goal.start is FollowFrom.WALL:
            self._known = Known.BESIDE
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

    @property
    def path(self) -> float:
        """Meters driven since the start or the last corner, turns in place not counted."""
        return self._path

    @property
    def skew(self) -> float:
        """The robot's heading (rad, counter-clockwise) from the direction of the wall it follows."""
        return self._view.sign * self._wall.angle

    def expect(self, distance: float) -> None:
        """Tells how far (m) the robot's center is from the wall, where that is not the set distance."""
        self._wall = SideWall(distance, 0.0, 0.1)

    def on_tick(self, percept: Percept, context: Context) -> None:
        """Takes in the sensors of the wall's side, and what odometry says of the wall."""
        self._view.read(percept)
        self._wall.predict(context.distance, context.turn * self._view.sign)

    # --- states --------------------------------------------------------------------------------------

    def search(self, percept: Percept, context: Context) -> Proposal:
        """Straight on until a wall is near, ahead or at a slant; then away from it."""
        view = self._view
        geometry, front = view.geometry, view.front_wall()
        room = self.config.distance - geometry.body_radius - 0.002
        if not is_free(obstacles(percept, geometry), geometry, 0.01, room):
            self._remaining = front[1] if front is not None else 0.5 * math.pi
            self._known = Known.SEARCHED
            self.fire("meet_wall")
            return self.proposal(STOP)
        wall = view.side_wall()
        if wall is not None and wall[0] < self.config.distance + 0.02:
            self._meet(wall)
            self.fire("found_wall")
        return self._drive(0.0)

    def follow(self, percept: Percept, context: Context) -> Proposal:
        """Keeps the wall's distance, and notices where it ends or another wall is ahead."""
        config, view = self.config, self._view
        self._path += context.distance
        self._settle(context)
        if self.goal.reach is not None and self._path >= self.goal.reach:
            self.finish(True, "followed as far as asked", self.skew)
            return self.proposal(STOP)
        self._trace_course(context)
        if self._at_front(view.slanted_wall(self._wall.distance, self._wall.angle)):
            return self.proposal(STOP)
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

    def advance(self, percept: Percept, context: Context) -> Proposal:
        """Drives past the wall's end, as far as the corner is from both walls."""
        view = self._view
        self._path += context.distance
        opening = self._leg >= _OPENING and view.side > self.config.lost_range
        if opening and self._is_at_front(view.front_wall()):
            # Across is the other wall of a passage: too narrow to pass its mouth, wide enough to enter.
            return self._around()
        if self._at_front():
            return self.proposal(STOP)
        self._leg += context.distance
        if self._leg >= self._past:
            return self._around()
        if min(view.side, view.diagonal) < self.config.shy:  # an edge that was met at a slant
            return self._drive(_SHY_TURN)
        return self._drive(-self.config.angle_gain * self._wall.angle)

    def on_enter_concave(self, context: Context) -> None:
        """Tells the corner."""
        self._arrive("concave", context)

    def concave(self, percept: Percept, context: Context) -> Proposal:
        """Turns away from the wall ahead, until it is at the side."""
        if not self._has_turned(context) and not self._is_parallel_already():
            return self._spin()
        self._end_turn(Known.SEARCHED if self._known is Known.SEARCHED else Known.TURNED, "found_wall")
        return self.proposal(STOP)

    def turn_away(self, percept: Percept, context: Context) -> Proposal:
        """Turns away from the wall ahead in the same way."""
        return self.concave(percept, context)

    def on_enter_convex(self, context: Context) -> None:
        """Tells the corner."""
        self._arrive("convex", context)

    def convex(self, percept: Percept, context: Context) -> Proposal:
        """Turns around the wall's end."""
        if not self._has_turned(context):
            return self._spin()
        self._end_turn(Known.ROUNDED, "turned")
        return self.proposal(STOP)

    def turn_toward(self, percept: Percept, context: Context) -> Proposal:
        """Turns farther around the wall's end."""
        return self.convex(percept, context)

    def edge(self, percept: Percept, context: Context) -> Proposal:
        """Drives to where the rest of a sharp turn leads along the next wall, at the set distance."""
        if self._drive_on(context):
            return self.proposal(STOP)
        past = (1.0 - math.cos(self._sharper) + math.sin(self._sharper)) / math.sin(self._sharper)
        if self._leg > past * self.config.distance:
            self._remaining, self._sharper = -self._sharper, 0.0
            self.fire("turn_more")
        return self._drive(-self.config.angle_gain * self._wall.angle)

    def gap(self, percept: Percept, context: Context) -> Proposal:
        """Drives until the next wall is at the side; turns farther where none comes."""
        if self._drive_on(context):
            return self.proposal(STOP)
        if self._view.side < self.config.lost_range:
            self._misses += 1
            if self._misses >= 2:
                self._find_wall(self._view)
        else:
            self._misses = 0
            if self._leg > self.config.gap_limit:
                self._remaining = -0.25 * math.pi
                self._leg = 0.0
                self.fire("turn_more")
        return self._drive(-self.config.angle_gain * self._wall.angle)

    # --- conditions of the table ------------------------------------------------------------------------

    def is_still_turning(self) -> bool:
        """Whether the wall ahead is the one just turned away from, and that was not enough; or turned to, and
        that was too much, as around a blunt corner.
        """
        if self._known is Known.ROUNDED and self._remaining < _BLUNT:
            return True
        askew = abs(self._remaining - 0.5 * math.pi) > 0.3
        just_turned = self._known is Known.SEARCHED or (self._known is Known.TURNED and askew)
        return just_turned and self._path < 0.01

    def is_sharp(self) -> bool:
        """Whether the corner turns so far that the rest of the turn comes past its edge."""
        return self._sharper > 0.0

    # --- parts of states -----------------------------------------------------------------------------

    def _keep(self, view: SideView, abreast: float) -> Proposal:
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

    def _around(self) -> Proposal:
        """Turns around the wall's end."""
        self._remaining = -self._edge - self._wall.angle
        self.fire("around")
        return self.proposal(STOP)

    def _drive_on(self, context: Context) -> bool:
        """One tick on a way without a wall at the side; whether it stands before a wall ahead."""
        self._path += context.distance
        self._leg += context.distance
        return self._at_front()

    def _find_wall(self, view: SideView) -> None:
        wall = view.side_wall()
        if wall is not None:
            self._meet(wall)
        else:
            self._wall = SideWall(view.geometry.body_radius + view.side, 0.0, _TURNED)
        self._misses = 0
        self._leg = 0.0
        self.fire("found_wall")

    def _has_turned(self, context: Context) -> bool:
        """Counts one tick of turning in place; whether it is over."""
        turned = context.turn * self._view.sign
        self._remaining -= turned
        self._turned += turned
        return abs(self._remaining) <= 0.004

    def _end_turn(self, known: Known, trigger: str) -> None:
        self._known = known
        self._turned = self._leg = 0.0
        self._misses = 0
        self._front.clear()
        self._wall = SideWall(self.config.distance, 0.0, 0.05)
        self.fire(trigger)

    def _is_parallel_already(self) -> bool:
        """Whether, turning away from a wall ahead, it is at the side long before expected: it stood askew."""
        if self._turned < 0.3 or self._remaining < 0.25:
            return False
        wall = self._view.side_wall()
        if wall is None or self._view.front_wall() is not None:
            return False
        return wall[1] > -0.02 and wall[0] < self.config.distance + 0.015

    def _at_front(self, slanted: tuple[float, float] | None = None) -> bool:
        """Stops for a wall ahead: looks a few ticks, standing, to learn where it lies, then turns."""
        front = slanted or self._view.front_wall()
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
        return True

    def _is_at_front(self, front: tuple[float, float] | None) -> bool:
        return front is not None and front[0] <= self.config.distance + 0.0005

    def _meet(self, wall: tuple[float, float]) -> None:
        self._wall.meet(wall)
        self._misses = 0

    def _arrive(self, kind: str, context: Context) -> None:
        """Says that a corner is reached, with the direction of the wall just followed."""
        self._publish_wall(context)
        self._known = Known.NEW
        self._tell(kind, self._remaining, context)

    def _tell(self, kind: str, remaining: float, context: Context) -> None:
        path, self._path = self._path, 0.0
        unobserved, self._seen = path - self._seen, 0.0
        course, self._course = self._course, WallCourse()
        context.publish(
            CornerReached(
                time=context.time,
                side=self.goal.side,
                kind=kind,
                path_length=path,
                heading=self._wall_direction(context),
                turn=remaining * self._view.sign,
                max_heading_change=course.max_heading_change,
                unobserved_length=unobserved,
            )
        )

    def _settle(self, context: Context) -> None:
        """Once enough of the new wall was followed, says where it leads."""
        self._leg += context.distance
        if self._leg >= self.config.settle and self._wall.samples >= 20:
            self._publish_wall(context)

    def _publish_wall(self, context: Context) -> None:
        if self._known is not Known.TOLD:
            self._known = Known.TOLD
            heading = self._wall_direction(context)
            context.publish(
                WallMet(time=context.time, side=self.goal.side, heading=heading, path_length=self._path)
            )

    def _trace_course(self, context: Context) -> None:
        """Keeps where the wall leads, and tells when it has turned far without a corner."""
        beside = self._known is Known.BESIDE and self._wall.samples >= _PARALLEL
        if not (beside or self._known is Known.TOLD):
            return
        if not self._course.take(self._path, self._wall_direction(context)):
            return
        if abs(self._course.swing) >= self.config.bend:
            self._tell(BEND, 0.0, context)
            self._known = Known.BESIDE

    def _wall_direction(self, context: Context) -> float:
        return wrap_angle(context.pose.heading - self._view.sign * self._wall.angle)

    def _drive(self, turn_rate: float) -> Proposal:
        """Forward while turning at `turn_rate` (rad/s at the set speed, away from the wall is positive)."""
        # Not along a wall whose direction was never seen, such as a thin one's end.
        ending = self._seen > 0.0 and self.state in (Following.FOLLOW, Following.ADVANCE)
        unseen = ending and self._path - self._seen > _UNSEEN
        speed = self.config.blind_speed if unseen else self.config.speed
        # Slower along the same way: as much turn in a meter.
        turn_rate *= self._view.sign * speed / self.config.speed
        return self.proposal(drive_command(self._view.geometry, speed, turn_rate))

    def _spin(self) -> Proposal:
        """Turns in place by what remains (rad, away from the wall is positive), or what a tick allows."""
        remaining = self._remaining * self._view.sign
        return self.proposal(spin_command(self._view.geometry, remaining, self.config.turn_speed))
