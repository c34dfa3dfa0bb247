"""Delay, interval and what else is set per sensor, as configuration."""

from __future__ import annotations

import difflib
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Generic, TypeVar

from ..errors import WorldError
from ..robot import CONTROL_PERIOD

T = TypeVar("T")
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
class Sensing:
    """The timing of every sensor; by default all are measured every tick and read at once."""

    infrared: Timing = field(default_factory=Timing)
    encoders: Timing = field(default_factory=Timing)
    accelerometer: Timing = field(default_factory=Timing)
    camera: Timing = field(default_factory=Timing)


def resolve_sensing(sensing: Sensing | Mapping[str, Any] | None) -> Sensing:
    """The timings meant by a mapping such as {"camera": {"delay": 0.096}}.

    Raises: WorldError for an unknown sensor or value, naming the nearest.
    """
    if sensing is None:
        return Sensing()
    if isinstance(sensing, Sensing):
        return sensing
    sensors = [entry.name for entry in fields(Sensing)]
    timings = {}
    for name, values in sensing.items():
        _check_known(name, sensors, "sensor")
        if not isinstance(values, Mapping):
            raise WorldError(f"{name}: expected a mapping with delay and interval, not {values!r}")
        for key, value in values.items():
            _check_known(key, ["delay", "interval"], f"{name} setting")
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise WorldError(f"{name} {key} must be a number of seconds, not {value!r}")
        timings[name] = Timing(**values)
        timings[name].ticks(name)
    return Sensing(**timings)


def _check_known(name: str, known: list[str], what: str) -> None:
    if name not in known:
        near = difflib.get_close_matches(str(name), known, 1, 0.5)
        hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
        raise WorldError(f"unknown {what} {name!r}; {hint}")


class Line(Generic[T]):
    """Values on their way from a sensor: measured every `interval` ticks, read `delay` ticks later."""

    def __init__(self, delay: int, interval: int) -> None:
        """Both in ticks."""
        self._delay, self._interval = delay, interval
        self._waiting: deque[tuple[int, T]] = deque()

    def due(self, tick: int) -> bool:
        """Whether a measurement is taken in this tick."""
        return not self._waiting or tick % self._interval == 0

    def put(self, tick: int, value: T) -> None:
        """Takes in this tick's measurement."""
        self._waiting.append((tick, value))

    def get(self, tick: int) -> T:
        """The newest value that has arrived by this tick, or the first ever."""
        while len(self._waiting) > 1 and self._waiting[1][0] + self._delay <= tick:
            self._waiting.popleft()
        return self._waiting[0][1]

    def clear(self) -> None:
        """Forgets all values."""
        self._waiting.clear()

    def state(self) -> list[tuple[int, T]]:
        """What is on its way."""
        return list(self._waiting)

    def restore(self, state: list[tuple[int, T]]) -> None:
        """Puts back what was on its way."""
        self._waiting = deque(state)
