"""What stood in the way, remembered: places that the infrared sensors hit, in the frame of the exploration.

Eight rays leave gaps; a corner's edge can slip between two of them. While the robot turns on the spot they
sweep over everything near by, and what they hit is kept for when it drives past.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...world.robot import Pose

_CELL = 0.008
_ENOUGH = 2


class ObstacleMemory:
    """Points (m, one fixed frame) that were hit at least twice within the same cell of 8 mm."""

    def __init__(self) -> None:
        """Empty."""
        self._cells: dict[tuple[int, int], tuple[int, float, float]] = {}

    def add(self, pose: Pose, points: Iterable[tuple[float, float]], reach: float = 0.09) -> None:
        """Takes points (m, robot frame) seen from `pose`, those within `reach` of the robot's center."""
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        for x, y in points:
            if x * x + y * y <= reach * reach:
                self._put(pose.x + cosine * x - sine * y, pose.y + sine * x + cosine * y, 1)

    def know(self, x: float, y: float) -> None:
        """Tells a point known beforehand (m, the frame's own)."""
        self._put(x, y, _ENOUGH)

    def blocks(self, start: tuple[float, float], end: tuple[float, float], clearance: float) -> bool:
        """Whether a drive from start to end comes within `clearance` (m) of a point ahead."""
        (x0, y0), (x1, y1) = start, end
        dx, dy = x1 - x0, y1 - y0
        length2 = max(dx * dx + dy * dy, 1e-12)
        for count, x, y in self._cells.values():
            if count < _ENOUGH:
                continue
            ox, oy = x - x0, y - y0
            share = (ox * dx + oy * dy) / length2
            if share <= 0.0:
                continue
            share = min(share, 1.0)
            if (ox - share * dx) ** 2 + (oy - share * dy) ** 2 < clearance * clearance:
                return True
        return False

    def _put(self, x: float, y: float, weight: int) -> None:
        key = (math.floor(x / _CELL), math.floor(y / _CELL))
        count, mean_x, mean_y = self._cells.get(key, (0, 0.0, 0.0))
        count += weight
        share = weight / count
        self._cells[key] = (count, mean_x + share * (x - mean_x), mean_y + share * (y - mean_y))
