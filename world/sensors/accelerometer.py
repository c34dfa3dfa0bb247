"""The accelerometer: the change of velocity over a tick, gravity included."""

from __future__ import annotations

import math

from ..noise.random_streams import normal
from ..robot import CONTROL_PERIOD
from .sensor import Motion, Mounting, Sensor

GRAVITY = 9.81


class Accelerometer(Sensor):
    """(x, y, z) m/s^2 in the robot's frame, the mean over the tick. Noise: normal, alike on every axis."""

    def __init__(self, mounting: Mounting) -> None:
        """Nothing is felt yet."""
        self._noise = mounting.noise.accelerometer
        self._rows = mounting.streams.rows("accelerometer", normal, 3)

    def measure(self, motion: Motion) -> tuple[float, float, float]:
        """The acceleration between this tick and the last."""
        east = (motion.velocity[0] - motion.velocity_before[0]) / CONTROL_PERIOD
        north = (motion.velocity[1] - motion.velocity_before[1]) / CONTROL_PERIOD
        cosine, sine = math.cos(motion.pose.heading), math.sin(motion.pose.heading)
        ahead, left = cosine * east + sine * north, cosine * north - sine * east
        if self._noise > 0.0:
            first, second, third = self._rows.row()
            size = self._noise
            return ahead + first * size, left + second * size, GRAVITY + third * size
        return ahead, left, GRAVITY
