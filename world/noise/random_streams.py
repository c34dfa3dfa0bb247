"""Random numbers a row at a time, drawn many rows at once: asking a generator costs more than the numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..geometry import Floats

ROWS = 64


class Draws:
    """The same numbers, and the same state after them, as from a generator that is asked row by row."""

    def __init__(
        self, random: np.random.Generator, draw: Callable[[np.random.Generator, int], Floats], width: int
    ) -> None:
        """draw: (generator, how many numbers); width: numbers in a row."""
        self._random, self._draw, self._width = random, draw, width
        self._before: Mapping[str, Any] = random.bit_generator.state
        self._rows: list[list[float]] = []
        self._used = 0

    def row(self) -> list[float]:
        """The next numbers."""
        if self._used == len(self._rows):
            self._before = self._random.bit_generator.state
            self._rows = self._draw(self._random, ROWS * self._width).reshape(ROWS, self._width).tolist()
            self._used = 0
        self._used += 1
        return self._rows[self._used - 1]

    @property
    def state(self) -> Mapping[str, Any]:
        """The generator's state after the rows that were asked for, whatever was drawn ahead."""
        if self._used == len(self._rows):
            return self._random.bit_generator.state
        ahead = self._random.bit_generator.state
        self._random.bit_generator.state = self._before
        if self._used:
            self._draw(self._random, self._used * self._width)
        state = self._random.bit_generator.state
        self._random.bit_generator.state = ahead
        return state

    @state.setter
    def state(self, state: Mapping[str, Any]) -> None:
        self._random.bit_generator.state = state
        self._rows, self._used = [], 0


def uniform(random: np.random.Generator, count: int) -> Floats:
    """Numbers in [0, 1)."""
    return random.random(count)


def normal(random: np.random.Generator, count: int) -> Floats:
    """Numbers of a standard normal distribution."""
    return random.standard_normal(count)
