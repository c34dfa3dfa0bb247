"""Local exploration: drives over the rigid graph around a node, sampling places and views (section 3.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.estimation.landmarks import FULL_SWEEP, SHORT_SWEEP, LandmarkFix
from ..agent.estimation.local_filter import LocalPose
from ..agent.exploration.itinerary import Itinerary
from ..agent.exploration.panoramas import QUARTER, PanoramaSamples, view_order
from ..agent.exploration.rigid_graph import Cell, RigidGraph
from ..agent.goals import ExploreLocally, LocalSamples
from ..agent.motion import drive_command, is_free, obstacles, shy_turn, spin_command
from ..world.robot import CONTROL_PERIOD, STOP, Image, Percept, RobotGeometry, wrap_angle


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
    """What local exploration is doing.

    PLAN: choosing the next place. AIM, DRIVE: to it. RETREAT: back from an obstacle. VIEW: taking a panorama.
    FIX: looking for the walls, to and fro; FIX_ROUND: right round; FACE_WALL, APPROACH, FIX_NEAR: from
    nearer by. GO_BACK: away from its place, to which it drives again. SQUARE_UP: turning to the heading it
    came with.
    """

    PLAN = "plan"
    AIM = "aim"
    DRIVE = "drive"
    RETREAT = "retreat"
    VIEW = "view"
    FIX = "fix"
    FIX_ROUND = "fix round"
    FACE_WALL = "face wall"
    APPROACH = "approach"
    FIX_NEAR = "fix near"
    GO_BACK = "go back"
    SQUARE_UP = "square-up"


_FIXES = (Exploring.FIX, Exploring.FIX_ROUND, Exploring.FIX_NEAR)


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
        Transition("aim", (Exploring.PLAN, Exploring.VIEW, Exploring.GO_BACK), Exploring.AIM),
        Transition("go", Exploring.AIM, Exploring.DRIVE),
        Transition("blocked", (Exploring.AIM, Exploring.RETREAT), Exploring.PLAN),
        Transition("retreat", Exploring.DRIVE, Exploring.RETREAT),
        Transition("arrived", Exploring.DRIVE, Exploring.PLAN),
        Transition("view", (Exploring.DRIVE, Exploring.PLAN), Exploring.VIEW),
        Transition("plan", Exploring.VIEW, Exploring.PLAN),
        Transition("fix", Exploring.PLAN, Exploring.FIX),
        Transition("nothing_seen", Exploring.FIX, Exploring.FIX_ROUND),
        Transition("nothing_seen", Exploring.FIX_ROUND, Exploring.FACE_WALL),
        Transition("facing", Exploring.FACE_WALL, Exploring.APPROACH),
        Transition("near_enough", Exploring.APPROACH, Exploring.FIX_NEAR),
        Transition("fixed", _FIXES, Exploring.PLAN),
        Transition("astray", _FIXES, Exploring.GO_BACK),
        Transition("home", Exploring.PLAN, Exploring.SQUARE_UP),
    )
    Goal = ExploreLocally
    config: LocalExplorationConfig
    goal: ExploreLocally

    def on_reset(self) -> None:
        """Forgets the place it was exploring."""
        self._target: Cell | None = None
        self._approached = 0.0
        self._positions: list[tuple[float, float]] = []
        self._samples = PanoramaSamples()
        self._viewed: set[Cell] = set()
        self._views: dict[int, Image] = {}
        self._headings: list[int] = []

    def on_start(self, context: Context) -> None:
        """Begins at the node, with the walls and obstacles that the goal knows of."""
        config, goal = self.config, self.goal
        self._pose = LocalPose(goal.heading, goal.square, goal.drift_rate)
        self._fix = LandmarkFix(context.geometry, self._pose, config.landmarks)
        rigid = RigidGraph(config.rows, config.columns, config.spacing)
        self._plan = Itinerary(rigid, self._pose, goal.strategy, config.landmarks)
        self._pose.know_corner(goal.corner, goal.walls)
        for x, y in goal.points:
            self._fix.memory.know(x, y)

    def on_tick(self, percept: Percept, context: Context) -> None:
        """Keeps the pose and, as often as it is due, the place."""
        self._fix.integrate(context)
        if self._due(self._positions, self.config.position_interval):
            self._positions.append((self._pose.x, self._pose.y))

    # --- states --------------------------------------------------------------------------------------

    def plan(self, percept: Percept, context: Context) -> Proposal:
        """Chooses what comes next: a panorama, a place, a fix, or home."""
        self._target = self._plan.next_cell()
        if self._view_is_due(at_place=True):
            self.fire("view")
        elif self._target is not None:
            self.fire("aim")
        else:
            self.fire("fix" if self._plan.wants_fix else "home")
        return self.proposal(STOP)

    def go_back(self, percept: Percept, context: Context) -> Proposal:
        """Its next place is the one it should be at."""
        self._target = self._plan.here
        self.fire("aim")
        return self.proposal(STOP)

    def aim(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the next place, and makes sure that the way there is free."""
        assert self._target is not None
        self._fix.sweep(percept)
        here, rigid = self._plan.here, self._plan.rigid
        driven = rigid.was_driven(here, self._target)
        if not driven and self._is_known_blocked(context.geometry):
            rigid.block(here, self._target)
            self.fire("blocked")
            return self.proposal(STOP)
        x, y, bearing = self._to(self._target)
        remaining = wrap_angle(bearing - self._pose.heading)
        if abs(remaining) > 0.006:
            return self._spin(remaining, self._calm(self.config.turn_speed), context)
        self._fix.correct()
        points = obstacles(percept, context.geometry)
        if driven or is_free(points, context.geometry, math.hypot(x, y), self.config.margin):
            self.fire("go")
        else:
            rigid.block(here, self._target)
            self.fire("blocked")
        return self.proposal(STOP)

    def drive(self, percept: Percept, context: Context) -> Proposal:
        """Drives to the place, or stops for a panorama or an obstacle on the way."""
        assert self._target is not None
        x, y, bearing = self._to(self._target)
        error = wrap_angle(bearing - self._pose.heading)
        remaining = math.hypot(x, y) * math.cos(error)
        if remaining < 0.001:
            self._plan.arrive(self._target)
            self.fire("arrived")
            return self.proposal(STOP)
        if self._view_is_due(at_place=False):
            self.fire("view")
            return self.proposal(STOP)
        points = obstacles(percept, context.geometry)
        known = self._plan.rigid.was_driven(self._plan.here, self._target)
        margin = self.config.touch_margin if known else self.config.stop_margin
        if not is_free(points, context.geometry, min(remaining, 0.01), margin):
            self._plan.rigid.block(self._plan.here, self._target)
            self._plan.retreats += 1
            self.fire("retreat")
            return self.proposal(STOP)
        away = shy_turn(points, context.geometry)
        return self._steer(self._calm(self._speed(remaining, context)), error, context, away)

    def retreat(self, percept: Percept, context: Context) -> Proposal:
        """Backwards, the way it came, to the place it left."""
        x, y, bearing = self._to(self._plan.here)
        error = wrap_angle(bearing + math.pi - self._pose.heading)
        remaining = math.hypot(x, y) * math.cos(error)
        if remaining < 0.001:
            self.fire("blocked")
            return self.proposal(STOP)
        return self._steer(-self._speed(remaining, context), error, context)

    def on_enter_view(self, context: Context) -> None:
        """Chooses in which order to look, so that it ends toward where it goes next."""
        after = None if self._target is None else self._to(self._target)[2]
        self._headings = view_order(self._pose.heading, after)
        self._fix.forget()

    def view(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the four directions of the local frame, one after the other, and looks."""
        self._fix.sweep(percept)
        if not self._headings:
            self._keep_panorama(context)
            self.fire("plan" if self._target in (None, self._plan.here) else "aim")
            return self.proposal(STOP)
        remaining = wrap_angle(QUARTER * self._headings[0] - self._pose.heading)
        if abs(remaining) > 0.004:
            return self._spin(remaining, self.config.turn_speed, context)
        self._views[self._headings.pop(0)] = context.look()
        return self.proposal(STOP)

    def on_enter_fix(self, context: Context) -> None:
        """Turns until a sensor faces the wall seen from here (at the node: home), then to and fro."""
        home = self._plan.here == self._plan.rigid.center
        turn = wrap_angle(-self._pose.heading) if home else self._fix.turn_to_see()
        self._fix.begin((turn, *SHORT_SWEEP))

    def fix(self, percept: Percept, context: Context) -> Proposal:
        """Looks for the walls known here, to and fro."""
        return self._look_for_walls(percept, context, self.config.fix_speed)

    def on_enter_fix_round(self, context: Context) -> None:
        """Right round."""
        self._fix.begin(FULL_SWEEP)

    def fix_round(self, percept: Percept, context: Context) -> Proposal:
        """Looks for the walls right round."""
        return self._look_for_walls(percept, context, self.config.turn_speed)

    def face_wall(self, percept: Percept, context: Context) -> Proposal:
        """Turns to where the wall must be."""
        error = self._to_wall()
        if abs(error) <= 0.006:
            self.fire("facing")
        return self._spin(error, self.config.turn_speed, context)

    def on_enter_approach(self, context: Context) -> None:
        """Counts the way from here."""
        self._approached = 0.0

    def approach(self, percept: Percept, context: Context) -> Proposal:
        """Toward where the wall must be, until it is near enough to be told from the noise."""
        self._approached += abs(context.distance)
        points = obstacles(percept, context.geometry)
        if self._approached >= self.config.approach or not is_free(points, context.geometry, 0.02, 0.005):
            self.fire("near_enough")
            return self.proposal(STOP)
        return self._steer(self.config.speed, self._to_wall(), context)

    def on_enter_fix_near(self, context: Context) -> None:
        """Right round."""
        self._fix.begin(FULL_SWEEP)

    def fix_near(self, percept: Percept, context: Context) -> Proposal:
        """Looks for the walls once more; whatever comes of it, it goes back to its place."""
        return self._look_for_walls(percept, context, self.config.turn_speed)

    def square_up(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the heading it came with."""
        remaining = wrap_angle(-self._pose.heading)
        if abs(remaining) > 0.004:
            return self._spin(remaining, self.config.fix_speed, context)
        visited, given_up = len(self._plan.visited), self._plan.given_up
        samples = LocalSamples(
            positions=np.array(self._positions, dtype=np.float64),
            panorama_positions=np.array(self._samples.places, dtype=np.float64),
            panoramas=np.array(self._samples.panoramas, dtype=np.float32),
            visited=visited,
            unreachable=given_up,
        )
        self.finish(True, f"{visited} places, {given_up} given up", samples)
        return self.proposal(STOP)

    # --- parts of states -----------------------------------------------------------------------------

    def _look_for_walls(self, percept: Percept, context: Context, speed: float) -> Proposal:
        command = self._fix.fix(percept, context, speed)
        if command is not None:
            return self.proposal(command)
        seen, near = self._fix.correct(), self.state is Exploring.FIX_NEAR
        if seen or near:
            there = self._plan.fixed(seen)
            self.fire("fixed" if there and not near else "astray")
        else:
            self.fire("nothing_seen")
        return self.proposal(STOP)

    def _to_wall(self) -> float:
        """How far (rad) the robot points away from the wall that it looks for."""
        return wrap_angle(self._plan.vantage_points().get(self._plan.here, 0.0) - self._pose.heading)

    def _keep_panorama(self, context: Context) -> None:
        panorama = np.array([self._views[k] for k in range(4)], dtype=np.float32)
        self._views = {}
        self._fix.correct()
        config = self.config
        if config.compass:
            field = context.geometry.camera_field_of_view
            self._samples.compare(panorama, self._pose, field, config.compass_views, config.compass_range)
        self._samples.add(panorama, self._pose)
        self._viewed.add(self._plan.here)

    def _is_known_blocked(self, geometry: RobotGeometry) -> bool:
        """Whether something remembered is in the way to the target."""
        assert self._target is not None
        clearance = geometry.body_radius + self.config.stop_margin
        start = (self._pose.x, self._pose.y)
        return self._fix.memory.blocks(start, self._plan.rigid.places[self._target], clearance)

    def _due(self, places: list[tuple[float, float]], interval: float) -> bool:
        return not places or math.dist((self._pose.x, self._pose.y), places[-1]) >= interval

    def _view_is_due(self, *, at_place: bool) -> bool:
        """At each place once, or every panorama_interval; not on a tour for fixes: turning costs heading."""
        if self.config.landmarks and self._plan.tour is not None:
            return False
        if self.config.panorama_interval > 0.0:
            return self._due(self._samples.places, self.config.panorama_interval)
        return at_place and self._plan.here not in self._viewed

    def _to(self, cell: Cell) -> tuple[float, float, float]:
        """dx, dy (m) and bearing (rad, local frame) from the robot to a place of the rigid graph."""
        x, y = self._plan.rigid.places[cell]
        dx, dy = x - self._pose.x, y - self._pose.y
        return dx, dy, math.atan2(dy, dx)

    def _calm(self, speed: float) -> float:
        """The speed, or less for the last leg home: the encoders err less the slower they count."""
        return 0.5 * speed if self.config.landmarks and self._plan.is_homeward else speed

    def _speed(self, remaining: float, context: Context) -> float:
        """The set speed, less for the last tick's way."""
        last = remaining / (context.geometry.distance_per_step * CONTROL_PERIOD)
        return min(self.config.speed, max(20.0, last))

    def _spin(self, remaining: float, speed: float, context: Context) -> Proposal:
        return self.proposal(spin_command(context.geometry, remaining, speed))

    def _steer(self, speed: float, error: float, context: Context, away: float = 0.0) -> Proposal:
        turn_rate = 3.0 * max(-0.3, min(0.3, error)) + away
        return self.proposal(drive_command(context.geometry, speed, turn_rate))
