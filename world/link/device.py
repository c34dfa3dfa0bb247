"""A simulated e-puck2 as its protocol sees it, without a socket: commands in, packets out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..errors import SimulationError
from ..robot import CONTROL_PERIOD, STOP, WheelCommand, wrap_angle
from . import packets, units
from .packets import Command, Sensors, wrapped

if TYPE_CHECKING:
    from ..base import World

CALIBRATION_TICKS = 32
"""Ticks (about 1 s) in which the robot takes the infrared's baseline and says nothing."""
SHINE = 0.1
"""What ambient light brightens by, in counts, for each count that a wall at hand reflects: an estimate."""


class Device:
    """The first robot of a world. `obey` commands, let time `pass`, then take `sensors` or an `image`.

    A robot that tips or flies off is put back where it began, as its owner would do; `falls` counts that.
    """

    def __init__(self, world: World, specimen: units.Specimen = units.IDEAL) -> None:
        """Stands still; the step counters are at zero."""
        self.world, self.specimen = world, specimen
        self.robot = world.robots[0]
        self.leds, self.sound, self.falls = 0, 0, 0
        self._begun = world.state()
        self._baseline: tuple[float, ...] = (0.0,) * 8
        self._zero = self.robot.sense().encoders
        self._heading = world.true_pose().heading
        self._turn_rate = 0.0

    def obey(self, command: Command) -> None:
        """Does what a command says, once: wheels, LEDs, counters, calibration (which takes a second)."""
        self.leds, self.sound = command.leds, command.sound
        if command.settings & packets.PRESET:
            left, right = self.robot.sense().encoders
            self._zero = left - command.left, right - command.right
        else:
            self.drive(command.left, command.right)
        if command.settings & packets.CALIBRATE:
            self._calibrate()

    def drive(self, left: float, right: float) -> None:
        """Sets the wheel speeds (steps/s), clipped as the robot clips them."""
        self.robot.act(WheelCommand(left, right).clamped(units.MAX_SPEED))

    def stop(self) -> None:
        """Wheels at zero."""
        self.robot.act(STOP)

    def tick(self) -> None:
        """Lets 32 ms pass."""
        try:
            self.world.step()
        except SimulationError:
            self.falls += 1
            self.world.restore(self._begun)
            self.stop()
        heading = self.world.true_pose().heading
        self._turn_rate = wrap_angle(heading - self._heading) / CONTROL_PERIOD
        self._heading = heading

    def sensors(self) -> Sensors:
        """What it senses now, in the robot's units."""
        percept = self.robot.sense()
        ahead, left, up = (value / units.GRAVITY * units.COUNTS_PER_G for value in percept.accelerometer)
        raw = self.specimen.raw(percept.infrared)
        lit = [max(0.0, value - base) for value, base in zip(raw, self._baseline, strict=True)]
        steps = [math.floor(now - zero + 0.5) for now, zero in zip(percept.encoders, self._zero, strict=True)]
        size = math.sqrt(ahead * ahead + left * left + up * up)
        tilt = math.degrees(math.acos(max(-1.0, min(1.0, up / size)))) if size else 0.0
        return Sensors(
            acceleration_vector=(_int16(left), _int16(ahead), _int16(up)),
            acceleration=size,
            orientation=math.degrees(math.atan2(left, ahead)) % 360.0 if 5.0 <= tilt <= 160.0 else 0.0,
            inclination=tilt,
            gyro=(0, 0, _int16(math.degrees(self._turn_rate) * units.GYRO_PER_DEGREE)),
            magnetometer=self._north(),
            proximity=tuple(min(4095, round(value)) for value in lit),
            ambient=tuple(
                max(0, min(units.DARK, self.specimen.ambient - round(SHINE * value))) for value in lit
            ),
            tof=self._tof(percept.readings.get("range", ())),
            steps=(wrapped(steps[0]), wrapped(steps[1])),
        )

    def image(self) -> bytes:
        """The payload of an image taken now."""
        return packets.pack_image(self.robot.look(packets.WIDTH, packets.HEIGHT, color=True))

    def _calibrate(self) -> None:
        """Takes the infrared's baseline: the mean of what is read in the next second."""
        total = [0.0] * 8
        for _ in range(CALIBRATION_TICKS):
            self.tick()
            raw = self.specimen.raw(self.robot.sense().infrared)
            total = [mean + value / CALIBRATION_TICKS for mean, value in zip(total, raw, strict=True)]
        self._baseline = tuple(total)

    def _north(self) -> tuple[float, float, float]:
        """The earth's field (uT) in the robot's frame, taking the world's y for north."""
        return 20.0 * math.sin(self._heading), 20.0 * math.cos(self._heading), -40.0

    @staticmethod
    def _tof(reading: tuple[float, ...]) -> int:
        nothing = not reading or reading[0] >= units.TOF_REACH
        return units.TOF_NOTHING if nothing else round(1000.0 * reading[0])


def _int16(value: float) -> int:
    return max(-32768, min(32767, round(value)))
