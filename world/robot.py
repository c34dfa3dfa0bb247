"""What an agent may know of a robot: its geometry, what it senses, how it is commanded.

The one module of the world that maps, agent and behaviors may import: it holds no ground truth.
Frames: x forward, y left, headings counter-clockwise in radians. Lengths in meters, times in seconds.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

CONTROL_PERIOD = 0.032
"""Simulated seconds of one control tick."""

RIGHT_FRONT, RIGHT_DIAGONAL, RIGHT, RIGHT_REAR = 0, 1, 2, 3
LEFT_REAR, LEFT, LEFT_DIAGONAL, LEFT_FRONT = 4, 5, 6, 7
"""Indices of the infrared sensors ps0..ps7, clockwise from straight ahead."""

Image = NDArray[np.float32]
"""One camera image: (height, width) luminance or (height, width, 3) RGB, in [0, 1], row 0 on top."""


def wrap_angle(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


@dataclass(frozen=True, slots=True)
class Pose:
    """A place and a heading: x, y in m, heading in rad, in whatever frame the owner says."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def distance_to(self, other: Pose) -> float:
        """Euclidean distance (m) between the two places."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def compose(self, x: float, y: float, heading: float = 0.0) -> Pose:
        """The pose (x, y, heading), given in this pose's own frame, in the frame this pose is in."""
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        return Pose(
            self.x + cosine * x - sine * y,
            self.y + sine * x + cosine * y,
            wrap_angle(self.heading + heading),
        )

    def relative(self, other: Pose) -> Pose:
        """`other` seen from this pose: the inverse of `compose`."""
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        x, y = other.x - self.x, other.y - self.y
        return Pose(cosine * x + sine * y, cosine * y - sine * x, wrap_angle(other.heading - self.heading))


@dataclass(frozen=True, slots=True)
class WheelCommand:
    """Wheel speeds in encoder steps per second, held for one control tick."""

    left: float
    right: float

    def is_finite(self) -> bool:
        """Whether both speeds are finite numbers."""
        return math.isfinite(self.left) and math.isfinite(self.right)

    def clamped(self, limit: float) -> WheelCommand:
        """The command with each speed cut to [-limit, limit] steps/s."""
        if -limit <= self.left <= limit and -limit <= self.right <= limit:
            return self
        return WheelCommand(max(-limit, min(limit, self.left)), max(-limit, min(limit, self.right)))


STOP = WheelCommand(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Percept:
    """Everything the robot senses in one tick, but for the camera, which is asked with `Robot.look`.

    infrared: eight raw values, 0..4095, large is near; order and angles as in `RobotGeometry`.
    encoders: (left, right) accumulated wheel steps since the start, noise included.
    accelerometer: (x, y, z) m/s^2, robot frame; (0, 0, 9.81) at rest.
    readings: what any further sensor of the robot measured, by its name, in its own unit: `range` is (m,).
    """

    tick: int
    time: float
    infrared: tuple[float, ...]
    encoders: tuple[float, float]
    accelerometer: tuple[float, float, float] = (0.0, 0.0, 9.81)
    readings: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RobotGeometry:
    """Sizes and sensor characteristics of a robot model, as its maker publishes them.

    infrared_angles: (8,) rad from straight ahead. infrared_response: rows of distance (m), raw value
    and relative noise; beyond the last row there is only a noise floor. extra_sensors: names of what it
    carries beyond infrared, encoders, accelerometer and camera.
    """

    name: str = "e-puck"
    wheel_radius: float = 0.0205
    track: float = 0.053
    body_radius: float = 0.035
    mass: float = 0.150
    steps_per_turn: int = 1000
    max_speed: float = 1000.0
    infrared_angles: tuple[float, ...] = (-0.30, -0.80, -1.57, -2.64, 2.64, 1.57, 0.80, 0.30)
    infrared_height: float = 0.033
    infrared_aperture: float = 0.1
    infrared_response: tuple[tuple[float, float, float], ...] = (
        (0.0, 4095.0, 0.002),
        (0.005, 2133.0, 0.003),
        (0.01, 1466.0, 0.007),
        (0.015, 601.0, 0.041),
        (0.02, 384.0, 0.015),
        (0.03, 235.0, 0.024),
        (0.04, 158.0, 0.029),
        (0.05, 120.0, 0.042),
        (0.06, 104.0, 0.031),
        (0.07, 67.0, 0.049),
    )
    camera_forward: float = 0.030
    camera_height: float = 0.028
    camera_field_of_view: float = 0.84
    extra_sensors: tuple[str, ...] = ()

    @property
    def distance_per_step(self) -> float:
        """Meters a wheel rolls in one encoder step (eq. 3.1)."""
        return 2.0 * math.pi * self.wheel_radius / self.steps_per_turn

    @property
    def radians_per_step(self) -> float:
        """Radians the robot turns for one step of difference between the wheels (eq. 3.4)."""
        return self.distance_per_step / self.track

    @property
    def infrared_range(self) -> float:
        """The farthest distance (m) that the infrared response tells apart."""
        return self.infrared_response[-1][0]

    def infrared_distance(self, value: float) -> float:
        """Distance (m) from the rim at which a raw infrared value is expected; inf beyond the range.

        Linear between the rows of the response; at most one row's noise below the last value still
        counts as the last row.
        """
        table = self.infrared_response
        last = table[-1]
        if value < last[1]:
            return last[0] if value >= last[1] * (1.0 - last[2]) else math.inf
        index = bisect_left(table, -value, key=lambda row: -row[1])
        if index == 0:
            return 0.0
        (near, high, _), (far, low, _) = table[index - 1], table[index]
        return near + (far - near) * (high - value) / (high - low)


EPUCK = RobotGeometry()
EPUCK2 = RobotGeometry(name="e-puck2", max_speed=1200.0, extra_sensors=("range",))


class Robot(Protocol):
    """What an agent drives. `sense` first, then `act`, once a tick; the world steps in between."""

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's sizes, as its maker publishes them (not this specimen's true ones)."""

    def sense(self) -> Percept:
        """Returns this tick's percept. Called once a tick; must not change the world."""

    def act(self, command: WheelCommand) -> None:
        """Sets the wheel speeds until the next tick: finite (else ValueError), clamped to max_speed."""

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """Takes one camera image, without time passing: luminance, or RGB where `color` is asked for."""
