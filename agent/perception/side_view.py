"""What the infrared sensors say about walls: points, and a filtered line at the robot's side.

Robot frame: x forward, y left (m). A `SideView` mirrors everything for a wall on the left, so that whoever
uses it can think of the wall as being on the right: turning away from it is always positive.
"""

from __future__ import annotations

import math

from ...world.robot import Percept, RobotGeometry, wrap_angle
from ..walls import away_from

_RIGHT = (0, 7, 1, 2, 3)
_LEFT = (7, 0, 6, 5, 4)
_GATE, _RECEDING = 16.0, 6.0
"""Squared standard deviations beyond which a measured line is refused; of one that recedes."""
_IN_FRONT = 0.008
"""Meters by which the diagonal sensor must hit something nearer than the wall at the side."""
_LEAST_TURN, _MOST_TURN = math.radians(17.0), math.radians(75.0)
"""Turns (rad) at a slanted wall ahead: less is a bend; more, and both front sensors see it."""
_SPACING, _SPAN = 0.01, 10
"""Meters between two directions kept of a wall, and over how many of them it counts as bending."""


class SideView:
    """One side's sensors as if the wall were on the right. Distances are from the rim (m), inf if none.

    near, far: the front sensors on the wall's side and on the other. sign: +1 right, -1 left; multiply a
    mirrored turn by it to get a counter-clockwise one.
    """

    def __init__(self, geometry: RobotGeometry, side: str) -> None:
        """side: "right" or "left"."""
        self.geometry = geometry
        self.sign = away_from(side)
        self._index = _RIGHT if side == "right" else _LEFT
        self._radius = geometry.body_radius
        angles = geometry.infrared_angles
        self._angles = tuple((math.cos(angles[i]), math.sin(angles[i])) for i in _RIGHT)
        self.near = self.far = self.diagonal = self.side = self.rear = math.inf

    def read(self, percept: Percept) -> None:
        """Takes over one percept. Called once a tick."""
        infrared, distance = percept.infrared, self.geometry.infrared_distance
        near, far, diagonal, side, rear = self._index
        self.near = distance(infrared[near])
        self.far = distance(infrared[far])
        self.diagonal = distance(infrared[diagonal])
        self.side = distance(infrared[side])
        self.rear = distance(infrared[rear])

    def side_wall(self) -> tuple[float, float] | None:
        """(distance, angle) of the line through what the side and diagonal sensors hit, or None.

        distance: from the robot's center (m). angle: of the robot's heading from the wall (rad), positive
        when it points away from the wall.
        """
        if self.side == math.inf or self.diagonal == math.inf:
            return None
        cos_d, sin_d = self._angles[2]
        cos_s, sin_s = self._angles[3]
        reach_d, reach_s = self._radius + self.diagonal, self._radius + self.side
        x1, y1 = reach_s * cos_s, reach_s * sin_s
        x2, y2 = reach_d * cos_d, reach_d * sin_d
        dx, dy = x2 - x1, y2 - y1
        length = math.hypot(dx, dy)
        return abs(x1 * dy - y1 * dx) / length, -math.atan2(dy, dx)

    def hits(self) -> tuple[tuple[float, float], ...]:
        """What the side sensor and, if nothing is ahead, the diagonal one hit.

        Each as distance from the robot's center (m) and bearing (rad, negative: the wall is on the right).
        """
        angles = self.geometry.infrared_angles
        side = (self._radius + self.side, angles[_RIGHT[3]])
        if self.side == math.inf:
            return ()
        if self.diagonal == math.inf or self.near != math.inf:
            return (side,)
        return side, (self._radius + self.diagonal, angles[_RIGHT[2]])

    def front_wall(self) -> tuple[float, float] | None:
        """(distance, angle) of the wall ahead: from the center (m), and how far to turn away to be parallel.

        From both front sensors the line through their hits; from one alone, as if it stood across.
        """
        near, far = self.near, self.far
        if near == math.inf and far == math.inf:
            return None
        cos_f, sin_f = self._angles[0]
        if near == math.inf or far == math.inf:
            reach = self._radius + min(near, far)
            return reach * cos_f, 0.5 * math.pi
        x1, y1 = (self._radius + near) * cos_f, (self._radius + near) * sin_f
        x2, y2 = (self._radius + far) * cos_f, -(self._radius + far) * sin_f
        dx, dy = x2 - x1, y2 - y1
        length = math.hypot(dx, dy)
        return abs(x1 * dy - y1 * dx) / length, math.atan2(dy, dx)

    def slanted_wall(self, distance: float, angle: float) -> tuple[float, float] | None:
        """The wall ahead where only this side's front and diagonal sensors hit it, as `front_wall` tells it.

        distance, angle: of the wall at the side, which the diagonal sensor hits if there is no other. None
        if there is none, or hardly turned against that one.
        """
        if self.near == math.inf or self.diagonal == math.inf or self.far < math.inf:
            return None
        (cos_n, sin_n), (cos_d, sin_d) = self._angles[0], self._angles[2]
        reach_n, reach_d = self._radius + self.near, self._radius + self.diagonal
        toward = cos_d * math.sin(-angle) - sin_d * math.cos(angle)
        if toward > 0.0 and reach_d > distance / toward - _IN_FRONT:
            return None
        x1, y1 = reach_d * cos_d, reach_d * sin_d
        x2, y2 = reach_n * cos_n, reach_n * sin_n
        dx, dy = x2 - x1, y2 - y1
        turn = math.atan2(dy, dx)
        if not _LEAST_TURN < turn < _MOST_TURN:
            return None
        return abs(x1 * dy - y1 * dx) / math.hypot(dx, dy), turn


class WallFilter:
    """Kalman filter of the side wall: distance of the center (m) and the heading from the wall (rad).

    Predicted by path integration, corrected by `SideView.side_wall`. `turn_noise` and `range_noise` are the
    standard deviations of one tick's turn and of one line's distance and angle.
    """

    __slots__ = ("_p00", "_p01", "_p11", "angle", "distance", "samples")

    turn_noise = 0.002
    drive_noise = 0.0001
    distance_noise = 0.0007
    angle_noise = 0.018

    def __init__(self, distance: float, angle: float = 0.0, spread: float = 0.1) -> None:
        """Starts at a guess with standard deviations of 1 cm and `spread` rad."""
        self.distance, self.angle = distance, angle
        self._p00, self._p01, self._p11 = 1e-4, 0.0, spread * spread
        self.samples = 0

    @property
    def angle_deviation(self) -> float:
        """Standard deviation (rad) of the angle."""
        return math.sqrt(self._p11)

    def predict(self, driven: float, turned: float) -> None:
        """One tick of path integration: driven (m), turned (rad, away from the wall is positive)."""
        self.distance += driven * math.sin(self.angle + 0.5 * turned)
        self.angle += turned
        p01, p11 = self._p01, self._p11
        self._p00 += 2.0 * driven * p01 + driven * driven * p11 + self.drive_noise * self.drive_noise
        self._p01 = p01 + driven * p11
        self._p11 = p11 + self.turn_noise * self.turn_noise

    def correct(self, wall: tuple[float, float]) -> bool:
        """Takes a measured line; False if it lies outside the gate and was refused.

        A line that recedes is gated more tightly: near a wall's end part of a sensor's cone misses the wall.
        """
        dd, da = wall[0] - self.distance, wall[1] - self.angle
        s00 = self._p00 + self.distance_noise**2
        s11 = self._p11 + self.angle_noise**2
        if (
            dd * dd > (_RECEDING if dd > 0.0 else _GATE) * s00
            or da * da > (_RECEDING if da > 0.0 else _GATE) * s11
        ):
            return False
        self._scalar(dd, s00, True)
        self._scalar(wall[1] - self.angle, self._p11 + self.angle_noise**2, False)
        self.samples += 1
        return True

    def correct_distance(self, distance: float) -> None:
        """Takes a distance alone, where the diagonal sensor sees nothing of the wall."""
        innovation = distance - self.distance
        variance = self._p00 + self.distance_noise**2
        if innovation * innovation <= (_RECEDING if innovation > 0.0 else _GATE) * variance:
            self._scalar(innovation, variance, True)

    def _scalar(self, innovation: float, variance: float, on_distance: bool) -> None:
        p00, p01, p11 = self._p00, self._p01, self._p11
        if on_distance:
            k0, k1 = p00 / variance, p01 / variance
            self._p00, self._p01, self._p11 = (1 - k0) * p00, (1 - k0) * p01, p11 - k1 * p01
        else:
            k0, k1 = p01 / variance, p11 / variance
            self._p00, self._p01, self._p11 = p00 - k0 * p01, (1 - k1) * p01, (1 - k1) * p11
        self.distance += k0 * innovation
        self.angle += k1 * innovation


class WallCourse:
    """Which way a wall has led since it was met: its direction (rad), once a centimeter.

    Odometry of unequal wheels turns along a straight wall too, but evenly and little within 10 cm.
    """

    __slots__ = ("_directions", "_next", "max_heading_change")

    def __init__(self) -> None:
        """Nothing is known of the wall yet."""
        self._directions: list[float] = []
        self._next = 0.0
        self.max_heading_change = 0.0

    def take(self, path: float, direction: float) -> bool:
        """Takes the wall's direction after `path` m of it; whether it was kept."""
        if self._directions and path < self._next:
            return False
        self._next = path + _SPACING - 1e-6
        kept = self._directions
        kept.append(kept[-1] + wrap_angle(direction - kept[-1]) if kept else direction)
        self.max_heading_change = max(
            self.max_heading_change, abs(kept[-1] - kept[max(0, len(kept) - 1 - _SPAN)])
        )
        return True

    @property
    def swing(self) -> float:
        """By how much (rad, counter-clockwise) the wall has turned since it was met."""
        return self._directions[-1] - self._directions[0] if self._directions else 0.0
