"""Walls as landmarks: what a turn in place tells of the walls around, and the pose that follows from it.

While the robot turns on the spot every infrared sensor sweeps along the walls near by. Seen from one point a
straight wall is 1 / r = a cos(t) + b sin(t), linear in (a, b): its foot and direction follow by least
squares, whatever angle it stands at. Walls met while the pose is well known are landmarks that correct it
later.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..world.robot import Percept, Pose, RobotGeometry, wrap_angle

_WINDOW = math.radians(32.0)
_FARTHEST = 0.055
"""Distance (m from the rim) beyond which a reading is too rough to place a wall by."""


class SeenWall(NamedTuple):
    """A wall seen from a place. normal: rad, toward its foot; distance: m; deviation: rad, of the normal."""

    normal: float
    distance: float
    deviation: float


class WallScan:
    """Collects readings while the robot turns in place, and finds the walls in them."""

    def __init__(self, geometry: RobotGeometry) -> None:
        """Starts empty."""
        self._geometry = geometry
        self._headings: list[float] = []
        self._values: list[tuple[float, ...]] = []

    def add(self, heading: float, percept: Percept) -> None:
        """Takes one tick's readings at `heading` (rad, any frame: that of the walls returned)."""
        self._headings.append(heading)
        self._values.append(percept.infrared)

    def walls(self) -> list[SeenWall]:
        """The walls whose foot was swept over, nearest first."""
        geometry = self._geometry
        if len(self._headings) < 10:
            return []
        table = np.array(geometry.infrared_response)
        values = np.array(self._values)
        distance = np.interp(-values, -table[:, 1], table[:, 0])
        near = distance < _FARTHEST
        angles = np.array(self._headings)[:, None] + np.array(geometry.infrared_angles)
        angle = np.mod(angles[near], math.tau)
        reach = geometry.body_radius + distance[near]
        found: list[SeenWall] = []
        for _ in range(4):
            wall = _nearest_wall(angle, reach)
            if wall is None:
                break
            seen, mine = wall
            if seen is not None:
                found.append(seen)
            angle, reach = angle[~mine], reach[~mine]
        return found


def _nearest_wall(
    angle: NDArray[np.float64], reach: NDArray[np.float64]
) -> tuple[SeenWall | None, NDArray[np.bool_]] | None:
    """The wall around the nearest readings, and which it explains. angle: (n,) rad; reach: (n,) m."""
    if len(angle) < 12:
        return None
    bins = (angle / math.tau * 72).astype(int) % 72
    sums, counts = np.bincount(bins, reach, 72), np.bincount(bins, minlength=72)
    means = np.where(counts >= 2, sums / np.maximum(counts, 1), np.inf)
    best = int(np.argmin(means))
    if not np.isfinite(means[best]):
        return None
    center = (best + 0.5) * math.tau / 72
    for _ in range(3):
        offset = np.remainder(angle - center + math.pi, math.tau) - math.pi
        window = np.abs(offset) < _WINDOW
        mine = window
        if window.sum() < 12:
            return None, mine
        x = np.column_stack((np.cos(offset[window]), np.sin(offset[window])))
        weight = 1.0 / reach[window]
        (a, b), *_ = np.linalg.lstsq(x * weight[:, None], weight * weight, rcond=None)
        residual = np.abs(1.0 / np.maximum(x @ (a, b), 1e-6) - reach[window])
        good = residual < max(0.003, 2.5 * float(np.median(residual)))
        if good.sum() < 10:
            return None, mine
        xg, wg = x[good], weight[good]
        (a, b), *_ = np.linalg.lstsq(xg * wg[:, None], wg * wg, rcond=None)
        shift = math.atan2(b, a)
        center += shift
        if abs(shift) < 0.01:
            break
    offset = offset - shift
    used = offset[window][good]
    spread = float(np.sqrt(np.mean(residual[good] ** 2)))
    both_sides = (used > 0.12).sum() >= 4 and (used < -0.12).sum() >= 4
    if not both_sides or spread > 0.0025 or good.mean() < 0.8:
        return None, mine
    foot = 1.0 / math.hypot(a, b)
    slope = foot * float(np.sqrt(np.sum(np.sin(used) ** 2)))
    deviation = max(0.002, spread / max(slope, 1e-6))
    return SeenWall(center, foot, deviation), mine


@dataclass(slots=True)
class _Landmark:
    normal: float
    offset: float
    variance: float
    offset_variance: float


@dataclass(slots=True)
class LandmarkPose:
    """A pose kept by path integration and corrected by walls seen before. Local frame: m, rad.

    heading_variance (rad^2), place_variance (m^2, each axis): of the pose. turn_noise, drive_noise: standard
    deviation of the odometry's error, per square root of a radian turned and of a meter driven. square: walls
    stand at right angles to the frame's axes.
    """

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    heading_variance: float = 1e-5
    place_variance: float = 1e-6
    turn_noise: float = 0.0085
    drive_noise: float = 0.0035
    square: bool = False
    _landmarks: list[_Landmark] = field(default_factory=list)

    @property
    def pose(self) -> Pose:
        """The estimate; the heading is not wrapped."""
        return Pose(self.x, self.y, self.heading)

    def move(self, distance: float, turn: float) -> None:
        """One tick of path integration (m, rad)."""
        middle = self.heading + 0.5 * turn
        self.x += distance * math.cos(middle)
        self.y += distance * math.sin(middle)
        self.heading += turn
        way = abs(distance)
        self.heading_variance += self.turn_noise**2 * abs(turn) + 0.05 * way * self.turn_noise
        self.place_variance += self.drive_noise**2 * way + way * way * self.heading_variance

    def see(self, wall: SeenWall) -> bool:
        """Corrects the pose by a wall seen from here (normal in the local frame); True if it was known.

        A wall is known if its normal agrees within 20 deg and its offset within 3 cm. A new one is kept with
        the pose's present uncertainty; where walls are square it tells the heading at once.
        """
        normal, offset = wall.normal, self._offset(wall.normal, wall.distance)
        best: _Landmark | None = None
        for mark in self._landmarks:
            turn = abs(wrap_angle(normal - mark.normal))
            if (
                turn < math.radians(20.0)
                and abs(self._offset(mark.normal, wall.distance) - mark.offset) < 0.03
            ):
                best = mark
                break
        if best is None:
            best = self._new_landmark(wall, offset)
            if best is None:
                return False
        self._turn_to(wrap_angle(best.normal - normal), best.variance + wall.deviation**2)
        self._shift_to(best, wall.distance)
        return True

    def _new_landmark(self, wall: SeenWall, offset: float) -> _Landmark | None:
        """Keeps a wall; returns it if its direction is known all the same, because all walls are square."""
        place_variance = self.place_variance + 0.0007**2
        quarter = 0.5 * math.pi
        if self.square:
            normal = quarter * round(wall.normal / quarter)
            if abs(wall.normal - normal) > 4.0 * math.sqrt(self.heading_variance + 0.01**2):
                return None
            mark = _Landmark(normal, self._offset(normal, wall.distance), 0.005**2, place_variance)
            self._landmarks.append(mark)
            return mark
        variance = self.heading_variance + wall.deviation**2
        self._landmarks.append(_Landmark(wall.normal, offset, variance, place_variance))
        return None

    def know(self, normal: float, distance: float, deviation: float) -> None:
        """Tells a wall known beforehand: normal (rad, local frame), its distance (m) from the origin."""
        self._landmarks.append(_Landmark(normal, distance, deviation**2, 0.001**2))

    def turn_by_compass(self, error: float, variance: float) -> None:
        """Corrects the heading by `error` (rad), known from elsewhere with `variance` (rad^2)."""
        self._turn_to(error, variance)

    def _turn_to(self, error: float, variance: float) -> None:
        total = self.heading_variance + variance
        if error * error > 16.0 * total:
            return
        gain = self.heading_variance / total
        self.heading += gain * error
        self.heading_variance *= 1.0 - gain

    def _shift_to(self, mark: _Landmark, distance: float) -> None:
        error = mark.offset - self._offset(mark.normal, distance)
        total = self.place_variance + mark.offset_variance + 0.0007**2
        if error * error > 16.0 * total:
            return
        gain = self.place_variance / total
        self.x += gain * error * math.cos(mark.normal)
        self.y += gain * error * math.sin(mark.normal)
        self.place_variance *= 1.0 - 0.5 * gain

    def _offset(self, normal: float, distance: float) -> float:
        return self.x * math.cos(normal) + self.y * math.sin(normal) + distance
