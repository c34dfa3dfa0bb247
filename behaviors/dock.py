"""Dock: comes to rest at a node in its transition pose, trimmed by the walls there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.goals import Dock
from ..agent.motion import drive_command, is_free, obstacles, spin_command
from ..agent.perception.side_view import SideView
from ..world.robot import CONTROL_PERIOD, STOP, Percept, Pose, wrap_angle


@dataclass(frozen=True, slots=True)
class DockConfig:
    """Settings. speed, turn_speed: steps/s. near: m from the place that will do. facing: rad that will do.

    margin: m of free space between shell and obstacle on the way. samples: ticks of standing that one
    measurement of the walls averages. rounds: of trimming, at most. trim: m of trimming, at most.
    """

    speed: float = 150.0
    turn_speed: float = 150.0
    near: float = 0.001
    facing: float = 0.01
    margin: float = 0.004
    samples: int = 10
    rounds: int = 4
    trim: float = 0.02


class Docking(Enum):
    """What docking is doing.

    AIM: turning to the place. DRIVE: driving there. FACE: turning to the final heading. MEASURE: standing,
    averaging where the walls are. TRIM_TURN, TRIM_DRIVE: correcting by what was measured.
    """

    AIM = "aim"
    DRIVE = "drive"
    FACE = "face"
    MEASURE = "measure"
    TRIM_TURN = "trim turn"
    TRIM_DRIVE = "trim drive"


class DockBehavior(Behavior):
    """Stops at a place with a heading. Goal: `agent.goals.Dock`. Result: (m, rad) trimmed by the walls.

    Drives there by path integration, then takes heading and place from the wall ahead, or the heading alone
    from the wall at its side, as far as the goal says that they are there. It fails when the way is blocked.
    """

    name = "dock"
    priority = 40
    States = Docking
    initial = Docking.AIM
    Config = DockConfig
    transitions = (
        Transition("drive", Docking.AIM, Docking.DRIVE),
        Transition("face", (Docking.AIM, Docking.DRIVE), Docking.FACE),
        Transition("measure", (Docking.FACE, Docking.TRIM_TURN, Docking.TRIM_DRIVE), Docking.MEASURE),
        Transition("trim_turn", Docking.MEASURE, Docking.TRIM_TURN),
        Transition("trim_drive", Docking.MEASURE, Docking.TRIM_DRIVE),
    )
    Goal = Dock
    example = Dock(Pose(0.05, 0.02, 0.5), side="right", wall_ahead=0.057)
    config: DockConfig
    goal: Dock

    def on_reset(self) -> None:
        """Forgets what was measured."""
        self._remaining = 0.0
        self._rounds = 0
        self._trimmed = [0.0, 0.0]
        self._angles: list[float] = []
        self._gaps: list[float] = []
        self._seen = 0

    def aim(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the place; hands over in the same tick when it is there, or faces it."""
        x, y = self._ahead(context)
        if math.hypot(x, y) < self.config.near:
            self.fire("face")
            return self.face(percept, context)
        self._remaining = math.atan2(y, x)
        if abs(self._remaining) < self.config.facing:
            self.fire("drive")
            return self.drive(percept, context)
        return self._spin(context)

    def drive(self, percept: Percept, context: Context) -> Proposal:
        """Drives to the place, steering by path integration."""
        geometry, config = context.geometry, self.config
        x, y = self._ahead(context)
        if x < config.near:
            self.fire("face")
            return Proposal(STOP, reason="at the place")
        if not is_free(obstacles(percept, geometry), geometry, min(x, 0.02), config.margin):
            self.finish(False, f"the way is blocked {x:.3f} m before the place")
            return Proposal(STOP, reason="blocked")
        step = x / (geometry.distance_per_step * CONTROL_PERIOD)
        turn_rate = 4.0 * math.atan2(y, x) if x > 0.01 else 0.0
        return Proposal(drive_command(geometry, min(config.speed, step), turn_rate), reason="driving there")

    def face(self, percept: Percept, context: Context) -> Proposal:
        """Turns to the final heading."""
        self._remaining = wrap_angle(self.goal.pose.heading - context.pose.heading)
        if abs(self._remaining) < self.config.facing:
            self.fire("measure")
            return Proposal(STOP, reason="facing")
        return self._spin(context)

    def measure(self, percept: Percept, context: Context) -> Proposal:
        """Stands still until it has seen enough of the walls, then judges how to trim."""
        goal = self.goal
        view = SideView(context.geometry, goal.side or "right")
        view.read(percept)
        if goal.wall_ahead is not None:
            # In a concave corner the diagonal sensor sees either wall: the wall ahead tells the heading.
            ahead = view.front_wall()
            if ahead is not None and max(view.near, view.far) < math.inf:
                self._angles.append((0.5 * math.pi - ahead[1]) * view.sign)
                self._gaps.append(ahead[0] - goal.wall_ahead)
        elif goal.side is not None and (beside := view.side_wall()) is not None:
            self._angles.append(beside[1] * view.sign)
        self._seen += 1
        if self._seen >= self.config.samples:
            self._judge()
        return Proposal(STOP, reason="measuring the walls")

    def trim_turn(self, percept: Percept, context: Context) -> Proposal:
        """Turns by what was measured."""
        self._remaining -= context.turn
        if abs(self._remaining) < 0.3 * self.config.facing:
            self.fire("measure")
            return Proposal(STOP, reason="trimmed")
        return self._spin(context)

    def trim_drive(self, percept: Percept, context: Context) -> Proposal:
        """Drives ahead or back by what was measured."""
        self._remaining -= context.distance
        if abs(self._remaining) < 0.2 * self.config.near:
            self.fire("measure")
            return Proposal(STOP, reason="trimmed")
        step = self._remaining / (context.geometry.distance_per_step * CONTROL_PERIOD)
        speed = max(-self.config.speed, min(self.config.speed, step))
        return Proposal(drive_command(context.geometry, speed, 0.0), reason="trimming the distance ahead")

    def _judge(self) -> None:
        config = self.config
        turn = -math.fsum(self._angles) / len(self._angles) if self._angles else 0.0
        way = math.fsum(self._gaps) / len(self._gaps) if self._gaps else 0.0
        self._angles, self._gaps, self._seen = [], [], 0
        self._rounds += 1
        good = abs(turn) <= 2.0 * config.facing and abs(way) <= config.near
        if good or self._rounds > config.rounds:
            self.finish(True, "docked", result=(self._trimmed[0], self._trimmed[1]))
        elif abs(turn) > 2.0 * config.facing:
            self._remaining = turn
            self._trimmed[1] += turn
            self.fire("trim_turn")
        else:
            self._remaining = max(-config.trim, min(config.trim, way))
            self._trimmed[0] += self._remaining
            self.fire("trim_drive")

    def _spin(self, context: Context) -> Proposal:
        command = spin_command(context.geometry, self._remaining, self.config.turn_speed)
        return Proposal(command, reason=f"turning: {self.state.value}")

    def _ahead(self, context: Context) -> tuple[float, float]:
        """Where the place is, robot frame (m)."""
        place = context.pose.relative(self.goal.pose)
        return place.x, place.y
