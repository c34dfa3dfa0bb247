"""One simulated robot: commands with limits, noisy wheels and encoders, sensors sampled once a tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from ..noise.model import Noise, streams
from ..noise.random_streams import Draws, normal, uniform
from ..robot import CONTROL_PERIOD, STOP, Image, Percept, Pose, RobotGeometry, WheelCommand
from .infrared import InfraredModel
from .sensing import Line, Sensing

GRAVITY = 9.81
Triple = tuple[float, float, float]


class Surroundings(Protocol):
    """What a robot needs of its world to sense."""

    def infrared_values(self, index: int, pose: Pose) -> list[float]:
        """Noise-free raw values of the eight sensors of robot `index` at a pose."""

    def infrared_model(self) -> InfraredModel:
        """The response of the infrared sensors."""

    def render(self, index: int, pose: Pose, width: int, height: int) -> Image:
        """A noise-free camera image of robot `index` at a pose."""


class SimulatedRobot:
    """Implements `robot.Robot` in any simulated world."""

    def __init__(
        self,
        world: Surroundings,
        index: int,
        geometry: RobotGeometry,
        noise: Noise,
        sensing: Sensing,
        seed: int,
    ) -> None:
        """Draws the run's wheel mismatch; `start` makes the first percept."""
        self._world, self._index = world, index
        self._geometry = geometry
        self._noise = noise
        self._random = streams(seed, index)
        self._draws = {
            "encoder": Draws(self._random["encoder"], uniform, 2),
            "slip": Draws(self._random["slip"], uniform, 2),
            "infrared": Draws(self._random["infrared"], normal, len(geometry.infrared_angles)),
            "accelerometer": Draws(self._random["accelerometer"], normal, 3),
        }
        self._command = STOP
        self._encoders = (0.0, 0.0)
        self._velocity = (0.0, 0.0)
        self._pose = Pose()
        self._percept = Percept(0, 0.0, (), (0.0, 0.0))
        self.collisions = 0
        self._lines: dict[str, Line[Any]] = {
            name: Line(*getattr(sensing, name).ticks(name))
            for name in ("infrared", "encoders", "accelerometer", "camera")
        }
        self._direct = all(getattr(sensing, name).ticks(name) == (0, 1) for name in self._lines)
        self._deviations = world.infrared_model().deviations(noise)
        self._infrared_noisy = noise.infrared > 0.0 or noise.infrared_floor > 0.0
        self.radius_factors = _radius_factors(noise, self._random["mismatch"])
        """True over nominal radius of the left and the right wheel in this run."""

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's sizes, as its maker publishes them."""
        return self._geometry

    def sense(self) -> Percept:
        """This tick's percept; the same one however often it is asked for."""
        return self._percept

    def act(self, command: WheelCommand) -> None:
        """Sets the wheel speeds until the next command.

        Raises: ValueError when a speed is not finite.
        """
        if not command.is_finite():
            raise ValueError(
                f"wheel speeds must be finite, not {command.left!r} and {command.right!r} steps/s"
            )
        self._command = command.clamped(self._geometry.max_speed)

    def look(self, width: int = 16, height: int = 16) -> Image:
        """One camera image (height, width), luminance in [0, 1].

        Raises: WorldError for a size outside 1x1..640x480.
        """
        pose = self._pose if self._direct else self._lines["camera"].get(self._percept.tick)
        image = self._world.render(self._index, pose, width, height)
        if self._noise.camera > 0.0:
            draws = self._random["camera"].standard_normal(image.shape, dtype=np.float32)
            image = np.clip(image + np.float32(self._noise.camera) * draws, 0.0, 1.0, dtype=np.float32)
        return image

    def wheel_speeds(self) -> tuple[float, float]:
        """How fast (rad/s) nominal wheels would have to turn to move as the true ones do in this tick."""
        scale = math.tau / self._geometry.steps_per_turn
        left = self._command.left * scale * self.radius_factors[0]
        right = self._command.right * scale * self.radius_factors[1]
        if self._noise.slip > 0.0:
            first, second = self._draws["slip"].row()
            left *= 1.0 - self._noise.slip * first
            right *= 1.0 - self._noise.slip * second
        return left, right

    def tick(self, tick: int, time: float, pose: Pose) -> None:
        """Takes in one tick that has passed: counts the encoders and samples the sensors at the true pose."""
        left, right = self._command.left * CONTROL_PERIOD, self._command.right * CONTROL_PERIOD
        if self._noise.encoder > 0.0:
            first, second = self._draws["encoder"].row()
            left *= 1.0 + self._noise.encoder * (2.0 * first - 1.0)
            right *= 1.0 + self._noise.encoder * (2.0 * second - 1.0)
        self._encoders = (self._encoders[0] + left, self._encoders[1] + right)
        velocity = (pose.x - self._pose.x) / CONTROL_PERIOD, (pose.y - self._pose.y) / CONTROL_PERIOD
        self._sample(tick, time, pose, velocity)

    def start(self, tick: int, time: float, pose: Pose) -> None:
        """Stands still at a pose it was put at, and senses there."""
        self._command = STOP
        self._velocity = (0.0, 0.0)
        for line in self._lines.values():
            line.clear()
        self._sample(tick, time, pose, (0.0, 0.0))

    def _sample(self, tick: int, time: float, pose: Pose, velocity: tuple[float, float]) -> None:
        acceleration = self._acceleration(pose, velocity)
        self._velocity, self._pose = velocity, pose
        if self._direct:
            self._percept = Percept(tick, time, self._infrared(pose), self._encoders, acceleration)
            return
        lines = self._lines
        if lines["infrared"].due(tick):
            lines["infrared"].put(tick, self._infrared(pose))
        for name, value in (("encoders", self._encoders), ("accelerometer", acceleration), ("camera", pose)):
            if lines[name].due(tick):
                lines[name].put(tick, value)
        infrared, encoders, felt, _ = (line.get(tick) for line in lines.values())
        self._percept = Percept(tick, time, infrared, encoders, felt)

    def _infrared(self, pose: Pose) -> tuple[float, ...]:
        values = self._world.infrared_values(self._index, pose)
        if not self._infrared_noisy:
            return tuple(values)
        return self._deviations.disturbed(values, self._draws["infrared"].row())

    def _acceleration(self, pose: Pose, velocity: tuple[float, float]) -> Triple:
        """The mean over the tick, (x, y, z) m/s^2 in the robot's frame, gravity included."""
        east = (velocity[0] - self._velocity[0]) / CONTROL_PERIOD
        north = (velocity[1] - self._velocity[1]) / CONTROL_PERIOD
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        ahead, left, up = cosine * east + sine * north, cosine * north - sine * east, GRAVITY
        if self._noise.accelerometer > 0.0:
            first, second, third = self._draws["accelerometer"].row()
            size = self._noise.accelerometer
            return ahead + first * size, left + second * size, up + third * size
        return ahead, left, up

    def state(self) -> dict[str, Any]:
        """All that changes, as plain data."""
        percept = self._percept
        lines = {
            name: [[tick, _plain(value)] for tick, value in line.state()]
            for name, line in self._lines.items()
        }
        return {
            "command": [self._command.left, self._command.right],
            "encoders": list(self._encoders),
            "velocity": list(self._velocity),
            "pose": _plain(self._pose),
            "collisions": self.collisions,
            "radius_factors": list(self.radius_factors),
            "percept": [
                percept.tick,
                percept.time,
                *map(list, (percept.infrared, percept.encoders, percept.accelerometer)),
            ],
            "lines": lines,
            "random": {
                name: self._draws[name].state if name in self._draws else random.bit_generator.state
                for name, random in self._random.items()
            },
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a state."""
        self._command = WheelCommand(*state["command"])
        self._encoders = _pair(state["encoders"])
        self._velocity = _pair(state["velocity"])
        self._pose = Pose(*state["pose"])
        self.collisions = int(state["collisions"])
        self.radius_factors = _pair(state["radius_factors"])
        tick, time, infrared, encoders, felt = state["percept"]
        self._percept = Percept(
            int(tick), float(time), tuple(infrared), _pair(encoders), (felt[0], felt[1], felt[2])
        )
        for name, line in self._lines.items():
            made = Pose if name == "camera" else _tuple
            line.restore([(tick, made(*value)) for tick, value in state["lines"][name]])
        for name, random in self._random.items():
            if name in self._draws:
                self._draws[name].state = state["random"][name]
            else:
                random.bit_generator.state = state["random"][name]


def _radius_factors(noise: Noise, random: np.random.Generator) -> tuple[float, float]:
    """True over nominal radius, left and right; their mean is exactly 1."""
    drawn = float(random.uniform(-1.0, 1.0)) * noise.mismatch
    # UMBmark's unequal wheels: right over left is 1 + unequal_wheels
    difference = drawn - 2.0 * noise.unequal_wheels / (2.0 + noise.unequal_wheels)
    return 1.0 + difference / 2.0, 1.0 - difference / 2.0


def _pair(values: Any) -> tuple[float, float]:
    first, second = values
    return float(first), float(second)


def _tuple(*values: float) -> tuple[float, ...]:
    return values


def _plain(value: Any) -> list[float]:
    return [value.x, value.y, value.heading] if isinstance(value, Pose) else list(value)
