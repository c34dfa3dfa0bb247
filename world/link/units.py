"""What the counts in the e-puck2's packets mean, and how this robot and its specimens are.

Sources: the firmware's own scales; GCtronic's data for the sensors; see docs/robots.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..robot import EPUCK2, RobotGeometry

GRAVITY = 9.81
COUNTS_PER_G = 768.0
GYRO_PER_DEGREE = 131.0
"""Counts per deg/s; the sensor ends at 250 deg/s."""
GYRO_TOP = 32767
TOF_NOTHING = 8190
"""What the time-of-flight chip reads where it sees nothing."""
TOF_REACH = 2.0
BATTERY_FULL = 3440
"""Counts at 4.2 V, 819.2 a volt; the robot warns at 2900."""
MAX_SPEED = 1100.0
"""Steps/s at which the robot clips what it is asked for."""
DARK = 4095
"""Ambient light of a dark room: the brighter, the smaller."""
E_PUCK2: RobotGeometry = replace(EPUCK2, max_speed=MAX_SPEED)
"""The e-puck2 as it can be driven over its link."""


@dataclass(frozen=True, slots=True)
class Specimen:
    """How one robot's infrared and light are; the wheels' deviations are the simulation's noise.

    gains: what each sensor reads over what the response says. offsets: counts it reads too many as long as
    its baseline is not taken (`tolman calibrate`). ambient: light counts with nothing before a sensor.
    """

    gains: tuple[float, ...] = (1.0,) * 8
    offsets: tuple[float, ...] = (0.0,) * 8
    ambient: int = 3300

    def raw(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """What its sensors read where ideal ones read `values`."""
        return tuple(
            gain * value + offset
            for gain, value, offset in zip(self.gains, values, self.offsets, strict=True)
        )


IDEAL = Specimen()
SPREAD, DRIFT = 0.15, 20.0
"""Standard deviation of a sensor's gain, as a share, and the most counts that its baseline drifts in a day.

The drift is the one that owners report; the spread is an estimate: no published figure was found.
"""


def drawn_specimen(seed: int) -> Specimen:
    """A robot off the shelf: gains and offsets of its own, which follow from the seed."""
    random = np.random.default_rng(np.random.SeedSequence([seed, 0xE2]))
    gains = np.clip(random.normal(1.0, SPREAD, 8), 0.6, 1.4)
    return Specimen(tuple(map(float, gains)), tuple(map(float, random.uniform(0.0, DRIFT, 8))))
