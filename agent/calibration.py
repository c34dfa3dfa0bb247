"""The wheels' mismatch, learned while driving: walls are straight, so what odometry turned is its error."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(slots=True)
class MismatchEstimate:
    """Scalar Kalman filter of the wheels' relative diameter difference, (right - left) / mean.

    value: the estimate; variance: of it. tick_turn: standard deviation (rad) of one tick's odometric turn,
    from encoder noise; tangent: of one wall tangent (rad).
    """

    value: float = 0.0
    variance: float = 0.0004
    tick_turn: float = 0.0015
    tangent: float = 0.006

    def straight(self, track: float, turned: float, length: float, tick_length: float = 0.00096) -> None:
        """Takes a straight stretch: `turned` (rad) by odometry, already with `value`, over `length` m."""
        if length < 0.05:
            return
        measured = self.value - track * turned / length
        ticks = length / tick_length
        noise = (track / length) ** 2 * (2.0 * self.tangent**2 + ticks * self.tick_turn**2)
        innovation = measured - self.value
        if abs(innovation) > 4.0 * math.sqrt(self.variance + noise):
            return
        gain = self.variance / (self.variance + noise)
        self.value += gain * innovation
        self.variance *= 1.0 - gain
