"""One simulated robot: commands with limits, noisy wheels, and sensors that are sampled once a tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..noise.random_streams import uniform
from ..robot import CONTROL_PERIOD, STOP, Image, Percept, Pose, RobotGeometry, WheelCommand
from ..sensors.delay_line import Line
from ..sensors.sensor import Motion, Mounting, Sensor

if TYPE_CHECKING:
    from ..noise.model import Noise
    from ..sensors.camera import Camera
    from ..sensors.registry import Fitted

PERCEPT_FIELDS = ("infrared", "encoders", "accelerometer")
"""Sensors whose values are fields of the percept; the camera is asked, and any other's are readings."""


class SimulatedRobot:
    """Implements `robot.Robot` in any simulated world."""

    def __init__(self, mounting: Mounting, sensors: Fitted) -> None:
        """Draws the run's wheel mismatch; `start` makes the first percept."""
        self._geometry, self._noise, self._streams = mounting.geometry, mounting.noise, mounting.streams
        self.radius_factors = _radius_factors(self._noise, self._streams.generator("mismatch"))
        """True over nominal radius of the left and the right wheel in this run."""
        self._slip = self._streams.rows("slip", uniform, 2)
        self._command = STOP
        self._motion = Motion()
        self._percept = Percept(0, 0.0, (), (0.0, 0.0))
        self.collisions = 0
        self.sensors: dict[str, Sensor] = {name: make(mounting) for name, (make, _) in sensors.items()}
        self._lines: dict[str, Line[Any]] = {
            name: Line(*timing.ticks(name)) for name, (_, timing) in sensors.items()
        }
        samples = {name: self._sampled(name) for name in sensors}
        self._infrared, self._encoders, self._accelerometer = (samples.pop(name) for name in PERCEPT_FIELDS)
        camera = samples.pop("camera")
        self._camera = None if self._lines["camera"].direct else camera
        self._extra = tuple(samples.items())
        self._advance = [each.advance for each in self.sensors.values() if _advances(each)]

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

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """One camera image: (height, width) luminance or (height, width, 3) RGB, in [0, 1].

        Raises: WorldError for a size outside 1x1..640x480.
        """
        camera: Camera = self.sensors["camera"]  # type: ignore[assignment]
        line = self._lines["camera"]
        pose = self._motion.pose if line.direct else line.get(self._percept.tick)
        return camera.look(pose, width, height, color)

    def wheel_speeds(self) -> tuple[float, float]:
        """How fast (rad/s) nominal wheels would have to turn to move as the true ones do in this tick."""
        scale = math.tau / self._geometry.steps_per_turn
        left = self._command.left * scale * self.radius_factors[0]
        right = self._command.right * scale * self.radius_factors[1]
        if self._noise.slip > 0.0:
            first, second = self._slip.row()
            left *= 1.0 - self._noise.slip * first
            right *= 1.0 - self._noise.slip * second
        return left, right

    def tick(self, tick: int, time: float, pose: Pose) -> None:
        """Takes in one tick that has passed, after which the robot truly is at `pose`."""
        motion, command = self._motion, self._command
        motion.steps = command.left * CONTROL_PERIOD, command.right * CONTROL_PERIOD
        before = motion.pose
        motion.velocity_before = motion.velocity
        motion.velocity = (pose.x - before.x) / CONTROL_PERIOD, (pose.y - before.y) / CONTROL_PERIOD
        motion.tick, motion.time, motion.pose = tick, time, pose
        for advance in self._advance:
            advance(motion)
        self._sample(motion)

    def start(self, tick: int, time: float, pose: Pose) -> None:
        """Stands still at a pose it was put at, and senses there."""
        self._command = STOP
        self._motion = Motion(tick, time, pose)
        for line in self._lines.values():
            line.clear()
        self._sample(self._motion)

    def _sample(self, motion: Motion) -> None:
        self._percept = Percept(
            motion.tick,
            motion.time,
            self._infrared(motion),
            self._encoders(motion),
            self._accelerometer(motion),
            {name: sample(motion) for name, sample in self._extra} if self._extra else {},
        )
        if self._camera is not None:
            self._camera(motion)

    def _sampled(self, name: str) -> Callable[[Motion], Any]:
        """What gives the newest value of a sensor that has arrived: its own measuring, unless it is late."""
        measure, line = self.sensors[name].measure, self._lines[name]

        def arrived(motion: Motion) -> Any:
            if line.due(motion.tick):
                line.put(motion.tick, measure(motion))
            return line.get(motion.tick)

        return measure if line.direct else arrived

    def state(self) -> dict[str, Any]:
        """All that changes, as plain data."""
        percept, motion = self._percept, self._motion
        kept = {name: sensor.state() for name, sensor in self.sensors.items()}
        return {
            "command": [self._command.left, self._command.right],
            "velocity": list(motion.velocity),
            "pose": _plain(motion.pose),
            "collisions": self.collisions,
            "radius_factors": list(self.radius_factors),
            "percept": [
                percept.tick,
                percept.time,
                *map(list, (percept.infrared, percept.encoders, percept.accelerometer)),
                {name: list(values) for name, values in percept.readings.items()},
            ],
            "lines": {
                name: [[tick, _plain(value)] for tick, value in line.state()]
                for name, line in self._lines.items()
            },
            "random": self._streams.state(),
        } | {name: state for name, state in kept.items() if state is not None}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a state, of which `state` is the form."""
        self._command = WheelCommand(*state["command"])
        self.collisions = int(state["collisions"])
        self.radius_factors = _pair(state["radius_factors"])
        tick, time, infrared, encoders, felt, *readings = state["percept"]
        self._percept = Percept(
            int(tick),
            float(time),
            tuple(infrared),
            _pair(encoders),
            (felt[0], felt[1], felt[2]),
            {name: tuple(values) for name, values in readings[0].items()} if readings else {},
        )
        self._motion = Motion(int(tick), float(time), Pose(*state["pose"]), _pair(state["velocity"]))
        for name, sensor in self.sensors.items():
            if sensor.state() is not None:
                sensor.restore(state[name])
        for name, line in self._lines.items():
            made = Pose if name == "camera" else _tuple
            line.restore([(tick, made(*value)) for tick, value in state["lines"][name]])
        self._streams.restore(state["random"])


def _advances(sensor: Sensor) -> bool:
    """Whether there is anything for it to do between measurements."""
    return type(sensor).advance is not Sensor.advance


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
