"""The contract of a sensor: one file a sensor, one line in `registry`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from ..errors import WorldError
from ..robot import CONTROL_PERIOD, Pose, RobotGeometry

if TYPE_CHECKING:
    from ..noise.model import Noise
    from ..noise.random_streams import Streams
    from .surroundings import Surroundings

MAX_DELAY = 10.0
"""Longest delay and interval (s) of a sensor."""


@dataclass(frozen=True, slots=True)
class Timing:
    """When a sensor's values arrive. delay: s from measuring to reading; interval: s between measurements."""

    delay: float = 0.0
    interval: float = CONTROL_PERIOD

    def ticks(self, sensor: str) -> tuple[int, int]:
        """(delay, interval) in control ticks.

        Raises: WorldError when either is not a multiple of the control period, or out of range.
        """
        return _ticks(self.delay, f"{sensor} delay", 0), _ticks(self.interval, f"{sensor} interval", 1)

    def changed(self, sensor: str, values: Timing | Mapping[str, Any]) -> Timing:
        """This timing with other values, such as {"delay": 0.096}.

        Raises: WorldError for an unknown or wrong value.
        """
        if isinstance(values, Timing):
            return values
        if not isinstance(values, Mapping):
            raise WorldError(f"{sensor}: expected a mapping with delay and interval, not {values!r}")
        for key, value in values.items():
            if key not in ("delay", "interval"):
                raise WorldError(f"unknown {sensor} setting {key!r}; known: delay, interval")
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise WorldError(f"{sensor} {key} must be a number of seconds, not {value!r}")
        return Timing(**{"delay": self.delay, "interval": self.interval, **values})


def _ticks(seconds: float, what: str, least: int) -> int:
    if not least * CONTROL_PERIOD - 1e-9 <= seconds <= MAX_DELAY:
        raise WorldError(f"{what} {seconds!r} s is outside {least * CONTROL_PERIOD:g} to {MAX_DELAY:g} s")
    ticks = round(seconds / CONTROL_PERIOD)
    if abs(ticks * CONTROL_PERIOD - seconds) > 1e-6:
        raise WorldError(
            f"{what} {seconds!r} s is not a multiple of the control period of {CONTROL_PERIOD} s"
        )
    return ticks


@dataclass(frozen=True, slots=True)
class Mounting:
    """What a sensor is made from. own: the index of the robot that carries it, in its surroundings.

    streams: for its noise; a purpose of its own, so that no other sensor's numbers change with it.
    """

    own: int
    geometry: RobotGeometry
    surroundings: Surroundings
    noise: Noise
    streams: Streams


@dataclass(slots=True)
class Motion:
    """How the robot truly moves; the robot keeps one and renews it every tick.

    velocity, velocity_before: (x, y) m/s, world frame, means over this tick and the last one.
    steps: (left, right) encoder steps that the wheels were commanded in this tick.
    """

    tick: int = 0
    time: float = 0.0
    pose: Pose = field(default_factory=Pose)
    velocity: tuple[float, float] = (0.0, 0.0)
    velocity_before: tuple[float, float] = (0.0, 0.0)
    steps: tuple[float, float] = (0.0, 0.0)


class Sensor(Protocol):
    """One sensor of one robot. `infrared`, `encoders` and `accelerometer` are fields of the percept; what any
    other sensor measures, a tuple of finite numbers, is in `Percept.readings` under its name.
    """

    timing: ClassVar[Timing] = Timing()
    """Delay and interval, unless a user sets others."""

    def __init__(self, mounting: Mounting) -> None:
        """Called once a run and robot."""

    def measure(self, motion: Motion) -> Any:
        """What is measured now. Called in the ticks in which a measurement is due."""

    def advance(self, motion: Motion) -> None:
        """Called every tick before anything is measured, for what goes on unmeasured; not after placing."""
        return  # a body, so that a sensor need not have this

    def state(self) -> Any:
        """What `advance` changes, as plain data; None: nothing. The streams are kept elsewhere."""
        return None

    def restore(self, state: Any) -> None:
        """Goes back to a state."""
        return
