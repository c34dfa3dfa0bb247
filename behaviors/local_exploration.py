"""Local exploration: drives over the rigid graph around a node, sampling places and views (section 3.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.estimation.landmarks import FULL_SWEEP, SHORT_SWEEP, VANTAGE_POINT, LandmarkFix
from ..agent.estimation.local_filter import LocalPose
from ..agent.exploration.panoramas import QUARTER, PanoramaSamples, view_order
from ..agent.exploration.rigid_graph import Cell, RigidGraph
from ..agent.goals import ExploreLocally, LocalSamples
from ..agent.motion import drive_command, is_free, obstacles, shy_turn, spin_command
from ..world.robot import STOP, Image, Percept, RobotGeometry, WheelCommand, wrap_angle

_PATIENCE = 12
"""Retreats before obstacles after which exploration goes home."""
_UNSURE = math.radians(2.5)
"""Standard deviation of the heading (rad) with which it does not go home from a place that told nothing."""
_AT_HOME, _HOMINGS = 0.0025, 2
"""Meters from the node that will do, and how often it is driven to again where a fix tells more."""
_BETWEEN_ERRANDS = 3
"""New places to be visited between two errands to see walls."""


@dataclass(frozen=True, slots=True)
class LocalExplorationConfig:
    """Settings of local exploration.

    rows, columns, spacing (m): the rigid graph. position_interval, panorama_interval (m): how far apart
    samples are taken; a panorama_interval of 0 takes one at each place of the rigid graph, where the robot
    stops anyway. speed, turn_speed: steps/s; fix_speed: the same while it turns to and fro for the walls.
    margin: free space (m) left between shell and obstacle where the robot goes; stop_margin: the same while
    driving, touch_margin: where it drove before. landmarks: whether walls swept while turning correct the
    pose, compass: whether views do (profile `thesis`: path integration alone). compass_views: so many nearest
    panoramas are compared, and the first, none farther than compass_range (m). approach: how far at most to
    drive toward a wall lost sight of (m).
    """

    rows: int = 5
    columns: int = 5
    spacing: float = 0.05
    position_interval: float = 0.02
    panorama_interval: float = 0.0
    speed: float = 233.0
    turn_speed: float = 450.0
    fix_speed: float = 150.0
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
    FIX = "fix"
    APPROACH = "approach"
    SQUARE_UP = "square-up"


class LocalExploration(Behavior):
    """Explores the space around the node the robot stands at and comes back to it.

    Goal: `agent.goals.ExploreLocally`. Finishes with `LocalSamples` as result, standing at the node again
    with the heading it came with. On the way home it goes by places from where walls of two directions can
    be seen, as at a convex corner none can be from the node.
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
        Transition("fix", Exploring.PLAN, Exploring.FIX),
        Transition("fixed", Exploring.FIX, Exploring.PLAN),
        Transition("nothing_seen", Exploring.FIX, Exploring.APPROACH),
        Transition("near_enough", Exploring.APPROACH, Exploring.FIX),
        Transition("home", Exploring.PLAN, Exploring.SQUARE_UP),
    )
    config: LocalExplorationConfig

    def on_reset(self) -> None:
        """Forgets the place it was exploring."""
        config = self.config
        self._rigid = RigidGraph(config.rows, config.columns, config.spacing)
        self._pose = LocalPose()
        self._fix = LandmarkFix(RobotGeometry(), self._pose, config.landmarks)
        self._here: Cell = self._rigid.center
        self._target: Cell | None = None
        self._queue: list[Cell] = []
        self._errand: Cell | None = None
        self._no_errand_before = 0
        self._tour: list[Cell] | None = None
        self._visited: set[Cell] = {self._here}
        self._given_up = 0
        self._retreats = 0
        self._rounded = False
        self._homings = 0
        self._approached = 0.0
        self._seen_from: Cell | None = None
        self._facing = self._astray = self._approaching = False
        self._positions: list[tuple[float, float]] = []
        self._samples = PanoramaSamples()
        self._viewed: set[Cell] = set()
        self._views: dict[int, Image] = {}
        self._headings: list[int] = []

    def on_start(self, goal: Any, context: Context) -> None:
        """Takes an `ExploreLocally` goal. Raises: TypeError for anything else."""
        if not isinstance(goal, ExploreLocally):
            raise TypeError(f"{self.name} needs an ExploreLocally goal, not {goal!r}")
        self._queue = self._rigid.order(goal.strategy)
        self._pose = LocalPose(goal.heading, goal.square, goal.drift_rate)
        self._fix = LandmarkFix(context.geometry, self._pose, self.config.landmarks)
        self._pose.know_corner(goal.corner, goal.walls)
        for x, y in goal.points:
            self._fix.memory.know(x, y)

    def propose(self, percept: Percept, context: Context) -> Proposal:
        """One tick of exploring."""
        self._fix.integrate(context)
        if self._due(self._positions, self.config.position_interval):
            self._positions.append((self._pose.x, self._pose.y))
        state = self.state
        if state is Exploring.PLAN:
            command = self._plan()
        elif state is Exploring.AIM:
            command = self._aim(percept, context)
        elif state is Exploring.DRIVE:
            command = self._drive(percept, context)
        elif state is Exploring.RETREAT:
            command = self._retreat(percept, context)
        elif state is Exploring.VIEW:
            command = self._view(percept, context)
        elif state is Exploring.FIX:
            command = self._take_fix(percept, context)
        elif state is Exploring.APPROACH:
            command = self._approach(percept, context)
        else:
            command = self._square_up(context)
        return Proposal(command, 1.0, state.value)

    # --- where to go ---------------------------------------------------------------------------------

    def _plan(self) -> WheelCommand:
        if self._astray:
            self._astray, self._target = False, self._here
            self.fire("aim")
            return STOP
        self._target = self._next_cell()
        if self._view_is_due(at_place=True):
            self._begin_view()
        elif self._target is not None:
            self.fire("aim")
        elif self._errand is not None or self._tour:
            self._rounded = False
            self._fix.begin((self._turn_for_fix(), *SHORT_SWEEP))
            self.fire("fix")
        else:
            self.fire("home")
        return STOP

    def _next_cell(self) -> Cell | None:
        """The next place to drive to, a neighbor of this one; None where a fix is wanted, or all is done."""
        if self._retreats > _PATIENCE:
            self._queue.clear()
        self._run_errands()
        if self._errand is not None:
            path = self._way(self._errand)
            return path[0] if path else None
        while self._queue:
            goal = self._queue[0]
            path = None if goal in self._visited else self._rigid.path(self._here, goal)
            if path:
                return path[0]
            self._given_up += goal not in self._visited
            self._queue.pop(0)
        if self._tour is None:
            home = self._rigid.center
            self._tour = [*(cell for cell in self._vantage_points() if cell != home), home]
        while self._tour:
            path = self._way(self._tour[0])
            if path:
                return path[0]
            if self._here == self._tour[0] and self._here in self._vantage_points():
                return None
            self._tour.pop(0)
        return None

    def _way(self, goal: Cell) -> list[Cell] | None:
        return self._rigid.path(self._here, goal) or self._rigid.way_back(self._here, goal)

    def _run_errands(self) -> None:
        """Where the pose has become doubtful, looks for walls first: at the nearest place that sees any."""
        early = len(self._visited) < self._no_errand_before
        if self._errand is not None or not self._queue or early or not self._pose.doubtful:
            return
        places = self._vantage_points()
        self._errand = min(places, key=lambda cell: self._rigid.distance(self._here, cell), default=None)

    def _vantage_points(self) -> dict[Cell, float]:
        """Visited places from where walls of two directions can be seen, the nearest to the node last.

        With each the direction (rad, local frame) of the wall there.
        """
        found: dict[Cell, float] = {}
        for mark in self._pose.vantage_points() if self.config.landmarks else ():
            places = self._rigid.places
            away = {cell: math.dist(places[cell], mark.vantage) for cell in sorted(self._visited)}
            cell = min(away, key=away.__getitem__)
            if away[cell] < VANTAGE_POINT:
                found[cell] = mark.normal
        return found

    # --- states --------------------------------------------------------------------------------------

    def _aim(self, percept: Percept, context: Context) -> WheelCommand:
        assert self._target is not None
        self._fix.sweep(percept)
        driven = self._rigid.was_driven(self._here, self._target)
        if not driven and self._is_known_blocked(context.geometry):
            self._rigid.block(self._here, self._target)
            self.fire("blocked")
            return STOP
        x, y, bearing = self._to(self._target)
        remaining = wrap_angle(bearing - self._pose.heading)
        if abs(remaining) > 0.006:
            return spin_command(context.geometry, remaining, self._calm(self.config.turn_speed))
        self._fix.correct()
        points = obstacles(percept, context.geometry)
        if driven or is_free(points, context.geometry, math.hypot(x, y), self.config.margin):
            self.fire("go")
        else:
            self._rigid.block(self._here, self._target)
            self.fire("blocked")
        return STOP

    def _is_known_blocked(self, geometry: RobotGeometry) -> bool:
        """Whether something remembered is in the way to the target."""
        assert self._target is not None
        clearance = geometry.body_radius + self.config.stop_margin
        start = (self._pose.x, self._pose.y)
        return self._fix.memory.blocks(start, self._rigid.places[self._target], clearance)

    def _calm(self, speed: float) -> float:
        """The speed, or less for the last leg home: the encoders err less the slower they count."""
        last = self.config.landmarks and self._tour == [self._rigid.center]
        return 0.5 * speed if last else speed

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
        if self._view_is_due(at_place=False):
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
        away = shy_turn(points, context.geometry)
        return self._steer(self._calm(self._speed(remaining, context)), error, context, away)

    def _retreat(self, percept: Percept, context: Context) -> WheelCommand:
        """Backwards, the way it came, to the place it left."""
        x, y, bearing = self._to(self._here)
        error = wrap_angle(bearing + math.pi - self._pose.heading)
        remaining = math.hypot(x, y) * math.cos(error)
        if remaining < 0.001:
            self.fire("blocked")
            return STOP
        return self._steer(-self._speed(remaining, context), error, context)

    def _view(self, percept: Percept, context: Context) -> WheelCommand:
        """Turns to the four directions of the local frame, one after the other, and looks."""
        self._fix.sweep(percept)
        if not self._headings:
            panorama = np.array([self._views[k] for k in range(4)], dtype=np.float32)
            self._views = {}
            self._fix.correct()
            config = self.config
            if config.compass:
                field = context.geometry.camera_field_of_view
                self._samples.compare(panorama, self._pose, field, config.compass_views, config.compass_range)
            self._samples.add(panorama, self._pose)
            self._viewed.add(self._here)
            self.fire("plan" if self._target in (None, self._here) else "aim")
            return STOP
        remaining = wrap_angle(QUARTER * self._headings[0] - self._pose.heading)
        if abs(remaining) > 0.004:
            return spin_command(context.geometry, remaining, self.config.turn_speed)
        self._views[self._headings.pop(0)] = context.look()
        return STOP

    def _take_fix(self, percept: Percept, context: Context) -> WheelCommand:
        """Looks for the walls known here: to and fro, then right round, then from nearer by."""
        speed = self.config.turn_speed if self._rounded else self.config.fix_speed
        command = self._fix.fix(percept, context, speed)
        if command is not None:
            return command
        seen = self._fix.correct()
        if seen:
            self._seen_from = self._here
        else:
            if not self._rounded:
                self._rounded = True
                self._fix.begin(FULL_SWEEP)
                return STOP
            if not self._approaching:
                self._approaching = self._astray = True
                self._approached = 0.0
                self.fire("nothing_seen")
                return STOP
        self._facing = self._approaching = False
        if self._errand is not None:
            self._errand = None
            self._no_errand_before = len(self._visited) + _BETWEEN_ERRANDS
        elif self._tour and self._is_at_place():
            self._tour.pop(0)
            if not seen:
                self._look_again()
        else:
            self._astray = True
        self.fire("fixed")
        return STOP

    def _look_again(self) -> None:
        """Looking in vain has cost heading: goes by the place that saw a wall last, once."""
        again, self._seen_from = self._seen_from, None
        unsure = self._pose.heading_variance > _UNSURE**2
        if unsure and self._tour and again is not None and again != self._here:
            self._tour.insert(0, again)

    def _is_at_place(self) -> bool:
        """Whether it stands where it should before it turns home, or has tried to often enough."""
        self._homings += 1
        away = math.dist((self._pose.x, self._pose.y), self._rigid.places[self._here])
        return self._here != self._rigid.center or away < _AT_HOME or self._homings > _HOMINGS

    def _turn_for_fix(self) -> float:
        """How far to turn (rad) so that a sensor faces the wall that can be seen here; at the node, home."""
        home = self._here == self._rigid.center
        return wrap_angle(-self._pose.heading) if home else self._fix.turn_to_see()

    def _approach(self, percept: Percept, context: Context) -> WheelCommand:
        """Toward where the wall must be, until it is near enough to be told from the noise."""
        normal = self._vantage_points().get(self._here, 0.0)
        error = wrap_angle(normal - self._pose.heading)
        if not self._facing:
            self._facing = abs(error) <= 0.006
            return spin_command(context.geometry, error, self.config.turn_speed)
        self._approached += abs(context.distance)
        points = obstacles(percept, context.geometry)
        if self._approached >= self.config.approach or not is_free(points, context.geometry, 0.02, 0.005):
            self._fix.begin(FULL_SWEEP)
            self.fire("near_enough")
            return STOP
        return self._steer(self.config.speed, error, context)

    def _square_up(self, context: Context) -> WheelCommand:
        remaining = wrap_angle(-self._pose.heading)
        if abs(remaining) > 0.004:
            return spin_command(context.geometry, remaining, self.config.fix_speed)
        samples = LocalSamples(
            positions=np.array(self._positions, dtype=np.float64),
            panorama_positions=np.array(self._samples.places, dtype=np.float64),
            panoramas=np.array(self._samples.panoramas, dtype=np.float32),
            visited=len(self._visited),
            unreachable=self._given_up,
        )
        self.finish(True, f"{len(self._visited)} places, {self._given_up} given up", samples)
        return STOP

    # --- parts of states -----------------------------------------------------------------------------

    def _due(self, places: list[tuple[float, float]], interval: float) -> bool:
        return not places or math.dist((self._pose.x, self._pose.y), places[-1]) >= interval

    def _view_is_due(self, *, at_place: bool) -> bool:
        """At each place once, or every panorama_interval; not on a tour for fixes: turning costs heading."""
        if self.config.landmarks and self._tour is not None:
            return False
        if self.config.panorama_interval > 0.0:
            return self._due(self._samples.places, self.config.panorama_interval)
        return at_place and self._here not in self._viewed

    def _begin_view(self) -> None:
        after = None if self._target is None else self._to(self._target)[2]
        self._headings = view_order(self._pose.heading, after)
        self._fix.forget()
        self.fire("view")

    def _to(self, cell: Cell) -> tuple[float, float, float]:
        """dx, dy (m) and bearing (rad, local frame) from the robot to a place of the rigid graph."""
        x, y = self._rigid.places[cell]
        dx, dy = x - self._pose.x, y - self._pose.y
        return dx, dy, math.atan2(dy, dx)

    def _speed(self, remaining: float, context: Context) -> float:
        """The set speed, less for the last tick's way."""
        last = remaining / (context.geometry.distance_per_step * 0.032)
        return min(self.config.speed, max(20.0, last))

    def _steer(self, speed: float, error: float, context: Context, away: float = 0.0) -> WheelCommand:
        return drive_command(context.geometry, speed, 3.0 * max(-0.3, min(0.3, error)) + away)
