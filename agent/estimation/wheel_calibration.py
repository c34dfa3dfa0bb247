"""The wheels' mismatch, learned while driving: walls are straight, so what odometry turned is its error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from ...world.robot import wrap_angle
from ..boundary.trace import BEND
from ..events import CornerReached, WallMet
from ..listener import Host, Listener
from .odometry import MISMATCH

if TYPE_CHECKING:
    from .odometry import PathIntegrator

SETTLED = 0.03
"""Meters of a wall that were followed before its direction was told."""
_TICK_LENGTH = 0.00096
"""Meters driven in a tick, at the speed at which walls are followed."""
_CROOKED = 0.12
"""Change of a wall's direction (rad) within 10 cm that no wheels explain: twice their worst, and noise."""


@dataclass(slots=True)
class MismatchEstimate:
    """Scalar Kalman filter of the wheels' relative diameter difference, (right - left) / mean.

    value: the estimate; variance: of it, at first that of +-2.1 % uniform. tick_turn: standard deviation
    (rad) of one tick's odometric turn, from encoder noise; tangent: of one wall tangent (rad).
    """

    value: float = 0.0
    variance: float = MISMATCH**2
    tick_turn: float = 0.0015
    tangent: float = 0.006

    @classmethod
    def of(cls, odometry: PathIntegrator) -> Self:
        """What odometry has been told."""
        return cls(odometry.mismatch, odometry.mismatch_deviation**2)

    def apply(self, odometry: PathIntegrator) -> None:
        """Has odometry use it."""
        odometry.mismatch, odometry.mismatch_deviation = self.value, math.sqrt(self.variance)

    def straight(self, track: float, turned: float, length: float) -> None:
        """Takes a straight stretch: `turned` (rad) by odometry, already with `value`, over `length` m."""
        if length < 0.05:
            return
        innovation = -track * turned / length
        noise = self._noise(track, length)
        if abs(innovation) > 4.0 * math.sqrt(self.variance + noise):
            return
        gain = self.variance / (self.variance + noise)
        self.value += gain * innovation
        self.variance *= 1.0 - gain

    def explains(self, track: float, turned: float, length: float) -> bool:
        """Whether odometry may have turned so (rad) along a straight wall of `length` m."""
        length = max(length, 0.02)
        return abs(track * turned / length) <= 4.0 * math.sqrt(self.variance + self._noise(track, length))

    def turn_deviation(self, track: float, length: float) -> float:
        """Standard deviation (rad) of what odometry turns over `length` m."""
        length = max(length, SETTLED)
        return math.sqrt(self.variance + self._noise(track, length)) * length / track

    def _noise(self, track: float, length: float) -> float:
        ticks = length / _TICK_LENGTH
        return (track / length) ** 2 * (2.0 * self.tangent**2 + ticks * self.tick_turn**2)


def is_even(event: CornerReached) -> bool:
    """Whether the wall just followed bends nowhere by more than unequal wheels make it seem."""
    return event.kind != BEND and event.max_heading_change < _CROOKED


class MismatchLearner(Listener):
    """Learns the wheels' mismatch from every straight wall that is followed, and has odometry use it."""

    def __init__(self, host: Host, odometry: PathIntegrator, track: float) -> None:
        """Hears what the wall follower tells of walls; begins at odometry's estimate. track: m."""
        super().__init__(host)
        self.estimate = MismatchEstimate.of(odometry)
        self._odometry, self._track = odometry, track
        self._wall: WallMet | None = None
        self.listen(WallMet, self._on_wall)
        self.listen(CornerReached, self._on_corner)

    def _on_wall(self, event: WallMet) -> None:
        self._wall = event

    def _on_corner(self, event: CornerReached) -> None:
        wall, self._wall = self._wall, None
        if wall is None or not is_even(event):
            return
        turned = wrap_angle(event.heading - wall.heading)
        length = event.path_length - wall.path_length - event.unobserved_length
        self.estimate.straight(self._track, turned, length)
        self.estimate.apply(self._odometry)
