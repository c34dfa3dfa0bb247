"""Values on their way from a sensor that is late or slow."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Line(Generic[T]):
    """Values on their way from a sensor: measured every `interval` ticks, read `delay` ticks later."""

    def __init__(self, delay: int, interval: int) -> None:
        """Both in ticks."""
        self.direct = (delay, interval) == (0, 1)
        """Whether every value is read in the tick in which it is measured, so that no line is needed."""
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
