"""The forward range finder: time of flight, as the VL53L0X of the e-puck2."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from ..geometry import Floats
from ..noise.random_streams import normal
from .sensor import Motion, Mounting, Sensor, Timing

FARTHEST = 2.0
"""m; what is farther is not seen, and reads as this."""
CONE = math.radians(25.0)
"""How wide its view is (rad), across and up: the nearest thing within is what it reads."""
TILT = 0.21
"""How far (rad) the middle of the view points above the horizon: low walls far away are seen by its rim."""
NOISE = 0.04
"""Standard deviation as a share of the distance (data sheet: a white target indoors, 33 ms a measurement)."""
_ACROSS, _UP = 7, 3
_RECESS = 0.005
"""How far (m) behind the rim the rays begin, so that a shell pressed at a wall does not look through it."""


class RangeFinder(Sensor):
    """(distance,) m from the rim, straight ahead, 0 to 2. Measured every 96 ms, read a tick later."""

    timing: ClassVar[Timing] = Timing(delay=0.032, interval=0.096)

    def __init__(self, mounting: Mounting) -> None:
        """Lays the rays over the cone, in the robot's frame."""
        across, up = np.meshgrid(
            np.linspace(-0.5, 0.5, _ACROSS) * CONE, TILT + np.linspace(-0.5, 0.5, _UP) * CONE
        )
        parts = np.cos(up) * np.cos(across), np.cos(up) * np.sin(across), np.sin(up)
        self._rays: Floats = np.stack(parts, axis=-1).reshape(-1, 3)
        self._own, self._surroundings = mounting.own, mounting.surroundings
        self._mount = mounting.geometry.body_radius - _RECESS
        self._height = mounting.geometry.infrared_height
        self._noise = mounting.noise.sensors * NOISE
        self._rows = mounting.streams.rows("range", normal, 1)

    def measure(self, motion: Motion) -> tuple[float]:
        """The distance to the nearest thing in the cone."""
        pose = motion.pose
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        turn = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        origin = (pose.x + self._mount * cosine, pose.y + self._mount * sine, self._height)
        origins = np.tile(origin, (len(self._rays), 1))
        distance = float(self._surroundings.distances(self._own, origins, self._rays @ turn).min()) - _RECESS
        if self._noise > 0.0:
            distance = min(distance, FARTHEST) * (1.0 + self._noise * self._rows.row()[0])
        return (min(max(distance, 0.0), FARTHEST),)
