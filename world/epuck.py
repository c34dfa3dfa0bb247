"""One simulated robot: commands with limits, noisy wheels and encoders, sensors sampled once a tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from .geometry import Floats
from .infrared import InfraredModel
from .noise import Noise, streams
from .robot import CONTROL_PERIOD, STOP, Image, Percept, Pose, RobotGeometry, WheelCommand


class Surroundings(Protocol):
    """What a robot needs from its world to sense."""

    def true_pose(self, robot: int = 0) -> Pose:
        """Where a robot really is."""

    def infrared_values(self, index: int, pose: Pose) -> Floats:
        """Noise-free raw values (8,)."""

    def infrared_model(self) -> InfraredModel:
        """The response of the infrared sensors."""

    def render(self, index: int, width: int, height: int) -> Image:
        """A noise-free camera image."""


class SimulatedRobot:
    """Implements `robot.Robot` in any simulated world."""

    def __init__(
        self, world: Surroundings, index: int, geometry: RobotGeometry, noise: Noise, seed: int
    ) -> None:
        """Draws the run's wheel mismatch and starts at rest."""
        self._world = world
        self._index = index
        self._geometry = geometry
        self._noise = noise
        self._random = streams(seed, index)
        self._command = STOP
        self._encoders = (0.0, 0.0)
        self._percept: Percept | None = None
        self.collisions = 0
        mismatch = float(self._random["mismatch"].uniform(-1.0, 1.0)) * noise.mismatch
        # UMBmark's unequal wheels: right over left diameter is 1 + unequal_wheels, their mean exact
        systematic = 2.0 * noise.unequal_wheels / (2.0 + noise.unequal_wheels)
        self.radius_factors = (1.0 + (mismatch - systematic) / 2.0, 1.0 - (mismatch - systematic) / 2.0)
        """True over nominal radius of the left and the right wheel in this run."""

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's sizes, as its maker publishes them."""
        return self._geometry

    def sense(self) -> Percept:
        """This tick's percept; the same one however often it is asked for."""
        if self._percept is None:
            self.sample(0, 0.0, self._world.true_pose(self._index))
        assert self._percept is not None
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
        """One camera image (height, width), luminance in [0, 1]."""
        image = self._world.render(self._index, width, height)
        if self._noise.camera > 0.0:
            draws = self._random["camera"].standard_normal(image.shape)
            image = np.clip(image + self._noise.camera * draws, 0.0, 1.0).astype(np.float32)
        return image

    def wheel_speeds(self) -> tuple[float, float]:
        """How fast (rad/s) nominal wheels would have to turn to move as the true ones do in this tick."""
        scale = math.tau / self._geometry.steps_per_turn
        left = self._command.left * scale * self.radius_factors[0]
        right = self._command.right * scale * self.radius_factors[1]
        if self._noise.slip > 0.0:
            slips = self._random["slip"].random(2)
            left *= 1.0 - self._noise.slip * float(slips[0])
            right *= 1.0 - self._noise.slip * float(slips[1])
        return left, right

    def count_encoders(self) -> None:
        """Counts this tick's wheel rotation, with the encoders' error."""
        left, right = self._command.left * CONTROL_PERIOD, self._command.right * CONTROL_PERIOD
        if self._noise.encoder > 0.0:
            errors = self._random["encoder"].random(2)
            left *= 1.0 + self._noise.encoder * (2.0 * float(errors[0]) - 1.0)
            right *= 1.0 + self._noise.encoder * (2.0 * float(errors[1]) - 1.0)
        self._encoders = (self._encoders[0] + left, self._encoders[1] + right)

    def sample(self, tick: int, time: float, pose: Pose) -> None:
        """Takes this tick's percept at the true pose."""
        values = self._world.infrared_values(self._index, pose)
        if self._noise.infrared > 0.0 or self._noise.infrared_floor > 0.0:
            values = self._world.infrared_model().noisy(values, self._noise, self._random["infrared"])
        self._percept = Percept(tick, time, tuple(values.tolist()), self._encoders)

    def stop(self, tick: int, time: float, pose: Pose) -> None:
        """Stands still at a pose it was put at, and senses there."""
        self._command = STOP
        self.sample(tick, time, pose)

    def state(self) -> dict[str, Any]:
        """All that changes, as plain data."""
        percept = self.sense()
        return {
            "command": [self._command.left, self._command.right],
            "encoders": list(self._encoders),
            "collisions": self.collisions,
            "radius_factors": list(self.radius_factors),
            "percept": [percept.tick, percept.time, list(percept.infrared), list(percept.encoders)],
            "random": {name: random.bit_generator.state for name, random in self._random.items()},
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a state."""
        left, right = state["encoders"]
        self._encoders = (float(left), float(right))
        self._command = WheelCommand(*state["command"])
        self.collisions = int(state["collisions"])
        factors = state["radius_factors"]
        self.radius_factors = (float(factors[0]), float(factors[1]))
        tick, time, infrared, encoders = state["percept"]
        self._percept = Percept(int(tick), float(time), tuple(infrared), (encoders[0], encoders[1]))
        for name, random in self._random.items():
            random.bit_generator.state = state["random"][name]
