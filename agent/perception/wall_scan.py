"""What a turn in place tells of the walls around.

While the robot turns on the spot every infrared sensor sweeps along the walls near by. Seen from one point a
straight wall is 1 / r = a cos(t) + b sin(t), linear in (a, b): its foot and direction follow by least
squares, whatever angle it stands at.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...world.robot import Percept, RobotGeometry

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
        self.geometry = geometry
        self._headings: list[float] = []
        self._values: list[tuple[float, ...]] = []

    def add(self, heading: float, percept: Percept) -> None:
        """Takes one tick's readings at `heading` (rad, any frame: that of the walls returned)."""
        self._headings.append(heading)
        self._values.append(percept.infrared)

    def walls(self) -> list[SeenWall]:
        """The walls whose foot was swept over, nearest first."""
        geometry = self.geometry
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
