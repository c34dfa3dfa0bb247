"""The wheels' mismatch, learned while driving: walls are straight, so what odometry turned is its error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..world.robot import wrap_angle
from .events import CornerReached, WallMet

if TYPE_CHECKING:
    from .agent import Agent

_SETTLED = 0.03
"""Meters of a wall that were followed before its direction was told."""


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


class MismatchLearner:
    """Learns the wheels' mismatch from every straight wall that is followed, and has odometry use it."""

    def __init__(self, agent: Agent, estimate: MismatchEstimate | None = None) -> None:
        """Subscribes to what the wall follower tells of walls. estimate: None: begins at odometry's."""
        self.estimate = estimate if estimate is not None else MismatchEstimate(agent.odometry.mismatch)
        self._agent = agent
        self._wall: WallMet | None = None
        self._subscriptions = [
            agent.bus.subscribe(WallMet, self._on_wall),
            agent.bus.subscribe(CornerReached, self._on_corner),
        ]

    def close(self) -> None:
        """Learns no more."""
        for subscription in self._subscriptions:
            subscription.cancel()

    def _on_wall(self, event: WallMet) -> None:
        self._wall = event

    def _on_corner(self, event: CornerReached) -> None:
        wall, self._wall = self._wall, None
        if wall is None:
            return
        turned = wrap_angle(event.heading - wall.heading)
        self.estimate.straight(self._agent.robot.geometry.track, turned, event.path_length - _SETTLED)
        self._agent.odometry.mismatch = self.estimate.value
