"""What the wall between two corners is like, and what it teaches about the wheels.

Unequal wheels make odometry turn along a straight wall, evenly, as along one that bends gently. A wall that
is straight by all that is known shows by how much; one that bends keeps the shape that odometry gave it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...world.robot import Pose, wrap_angle
from ..boundary.trace import BEND, WallSegment
from .wheel_calibration import MismatchEstimate, is_even

if TYPE_CHECKING:
    from ..events import CornerReached, WallMet
    from .odometry import PathIntegrator

_DETOUR, _DETOUR_SLOPE = 0.012, 0.02
"""By how much (m) the way along a wall may be longer than its chord if that wall is straight."""
_UNSURE = 0.003
"""Standard deviation of the mismatch beyond which a bend may be the wheels' doing."""


@dataclass(frozen=True, slots=True)
class _Passed:
    """What was driven (m) and turned (rad) along this wall up to a bend that was none.

    settled: m of it, the first, after which its direction was known.
    """

    length: float = 0.0
    swing: float = 0.0
    settled: float | None = None


class WallSegmentMeter:
    """Follows what the wall follower tells from corner to corner.

    mismatch: what is known of the wheels. wall: the one met last, to be set when one is met.
    """

    def __init__(self, odometry: PathIntegrator, track: float, learn: bool = True) -> None:
        """track: m, between the wheels. learn: whether straight walls teach the wheels' mismatch."""
        self.mismatch = MismatchEstimate()
        self._odometry, self._track, self._learn = odometry, track, learn
        self.wall: WallMet | None = None
        self._left: Pose | None = None
        self._passed = _Passed()

    @property
    def unsure(self) -> bool:
        """Whether too little is known of the wheels to tell a gentle bend from a straight wall."""
        return self._learn and math.sqrt(self.mismatch.variance) > _UNSURE

    def place_deviation(self, loop: float) -> float:
        """Standard deviation (m, along the wall) of a place found again by odometry alone after `loop` m."""
        return self.mismatch.turn_deviation(self._track, loop) * loop / math.tau

    def leave(self) -> None:
        """The robot stands where the next way begins."""
        self._left = self._odometry.pose

    def arrive(self, event: CornerReached) -> tuple[CornerReached, WallSegment | None] | None:
        """The corner with the whole length of the way to it, and that way if it is not straight.

        None if it is no bend after all.
        """
        swing = 0.0 if self.wall is None else wrap_angle(event.heading - self.wall.heading)
        event = replace(event, path_length=event.path_length + self._passed.length)
        swing += self._passed.swing
        if event.kind == BEND and self.mismatch.explains(self._track, swing, event.path_length):
            self._passed = _Passed(event.path_length, swing, self._settled)
            return None
        way = self._way(event, swing)
        self._passed = _Passed()
        self.leave()
        return event, way

    def calibrate(self, turned: float, driven: float, passed: float) -> None:
        """Takes a drive back along the wall, and here again: `driven` m in all, of the `passed` m behind.

        turned: rad, by odometry, turns in place left out. Whatever the wall does is undone on the way back.
        """
        before = self.mismatch.value
        self.mismatch.straight(self._track, turned, driven)
        self.mismatch.apply(self._odometry)
        if self.wall is not None:
            # Measured before the drive, and with other wheels.
            learned = (self.mismatch.value - before) * passed / self._track
            self.wall = replace(self.wall, heading=wrap_angle(self.wall.heading + turned - learned))
        self._left = None

    def _way(self, event: CornerReached, swing: float) -> WallSegment | None:
        if self.wall is None:
            return None
        if self._left is not None:
            begin = Pose(self._left.x, self._left.y, self.wall.heading - self._passed.swing)
            end = begin.relative(self._odometry.pose)
            if not self._is_straight(event, swing, math.hypot(end.x, end.y)):
                return WallSegment(end.x, end.y, swing)
        if self._learn and is_even(event):
            self.mismatch.straight(
                self._track, swing, event.path_length - self._settled - event.unobserved_length
            )
            self.mismatch.apply(self._odometry)
        return None

    @property
    def _settled(self) -> float:
        """Meters of this wall after which its direction was known."""
        if self._passed.settled is not None:
            return self._passed.settled
        return self.wall.path_length if self.wall is not None else 0.0

    def _is_straight(self, event: CornerReached, swing: float, chord: float) -> bool:
        """Whether the wall just followed was, as far as the wheels can be trusted. chord: m, end to end."""
        length = event.path_length
        if not is_even(event) or length - chord > _DETOUR + _DETOUR_SLOPE * length:
            return False
        return self.mismatch.explains(self._track, swing, length)
