"""Where the robot is in a node's local space: path integration, and walls swept while it turns."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...world.robot import Percept, RobotGeometry, WheelCommand, wrap_angle
from ..behavior import Context
from ..motion import obstacles, spin_command
from ..perception.obstacle_map import ObstacleMemory
from ..perception.wall_scan import WallScan
from .local_filter import LocalPose

SHORT_SWEEP = (math.radians(36.0), math.radians(-72.0), math.radians(36.0))
"""Turns (rad) that lead every infrared sensor to and fro: together they sweep nearly the whole round."""
FULL_SWEEP = (math.tau,)
VANTAGE_POINT = 0.035
"""How near (m) the robot must be to a wall's vantage point to count on seeing that wall."""
_THERE = 0.006


class LandmarkFix:
    """Keeps a `LocalPose` while a behavior drives, and corrects it by the walls that turns in place sweep.

    `integrate` every tick, `sweep` while turning, `correct` when a turn is over. A fix of its own is a turn
    to and fro (`SHORT_SWEEP`, short, so that little is lost by odometry on the way) or right round
    (`FULL_SWEEP`).
    """

    def __init__(self, geometry: RobotGeometry, pose: LocalPose, landmarks: bool = True) -> None:
        """landmarks: False keeps to path integration alone."""
        self.pose = pose
        self.landmarks = landmarks
        self.memory = ObstacleMemory()
        self._geometry = geometry
        self._scan = WallScan(geometry)
        self._turns: list[float] = []

    def integrate(self, context: Context) -> None:
        """One tick of path integration."""
        self.pose.move(context.distance, context.turn)

    def sweep(self, percept: Percept) -> None:
        """Takes in what the sensors sweep over while the robot turns in place."""
        if self.landmarks:
            self._scan.add(self.pose.heading, percept)
            self.memory.add(self.pose.pose, obstacles(percept, self._geometry))

    def correct(self) -> bool:
        """Corrects the pose by the walls swept over in the turn that just ended; True if by a known one."""
        known = False
        if self.landmarks:
            for wall in self._scan.walls():
                known |= self.pose.see(wall)
        self.forget()
        return known

    def forget(self) -> None:
        """Drops what was swept over: the robot drives on, and it would be seen from elsewhere."""
        self._scan = WallScan(self._geometry)

    def begin(self, turns: Sequence[float]) -> None:
        """Begins a fix: turns in place (rad, counter-clockwise) one after the other."""
        self.forget()
        self._turns = list(turns)

    def turn_to_see(self) -> float:
        """How far to turn (rad) so that a sensor, or the two ahead, faces the known wall nearest to here."""
        pose = self.pose
        faces = (0.0, *self._geometry.infrared_angles)
        turns = []
        for mark in pose.landmarks:
            if math.dist(mark.vantage, (pose.x, pose.y)) < VANTAGE_POINT:
                away = mark.offset - pose.x * math.cos(mark.normal) - pose.y * math.sin(mark.normal)
                turn = min((wrap_angle(mark.normal - pose.heading - face) for face in faces), key=abs)
                turns.append((away, turn))
        return min(turns)[1] if turns else 0.0

    def fix(self, percept: Percept, context: Context, speed: float) -> WheelCommand | None:
        """One tick of the fix begun, at `speed` (steps/s); None when its turns are over: then `correct`."""
        self.sweep(percept)
        if not self._turns:
            return None
        self._turns[0] -= context.turn
        while self._turns and abs(self._turns[0]) <= _THERE:
            self._turns.pop(0)
        return spin_command(context.geometry, self._turns[0], speed) if self._turns else None
