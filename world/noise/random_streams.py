"""Where the randomness comes from: a stream for each purpose of each robot, all from one seed."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import WorldError

ROWS = 64
Floats = NDArray[np.float64]
Kind: TypeAlias = Callable[[np.random.Generator, int], Floats]
"""What is drawn: (generator, how many) to numbers."""
_KEYS = ("mismatch", "encoder", "slip", "infrared", "camera", "accelerometer")
"""Purposes whose key is their place here; any other purpose's key comes from its name."""


class Rows:
    """The same numbers, and the same state after them, as from a generator that is asked row by row.

    Many rows are drawn at once: asking a generator costs more than the numbers.
    """

    def __init__(self, random: np.random.Generator, kind: Kind, width: int) -> None:
        """width: numbers in a row."""
        self._random, self._draw, self._width = random, kind, width
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


class Streams:
    """The streams of one robot. A stream depends on seed, robot and purpose alone, not on who else draws."""

    def __init__(self, seed: int, robot: int) -> None:
        """Raises: WorldError for a negative seed."""
        if seed < 0:
            raise WorldError(f"seed {seed} is negative; use 0 or more")
        self._seed, self._robot = seed, robot
        self._generators: dict[str, np.random.Generator] = {}
        self._rows: dict[str, Rows] = {}

    def generator(self, purpose: str) -> np.random.Generator:
        """The generator of a purpose."""
        if purpose not in self._generators:
            key = _KEYS.index(purpose) if purpose in _KEYS else zlib.crc32(purpose.encode())
            sequence = np.random.SeedSequence(self._seed, spawn_key=(self._robot, key))
            self._generators[purpose] = np.random.Generator(np.random.PCG64(sequence))
        return self._generators[purpose]

    def rows(self, purpose: str, kind: Kind, width: int) -> Rows:
        """The generator of a purpose, asked for `width` numbers at a time."""
        self._rows[purpose] = Rows(self.generator(purpose), kind, width)
        return self._rows[purpose]

    def state(self) -> dict[str, Mapping[str, Any]]:
        """The state of every stream that is in use, by purpose."""
        return {
            purpose: self._rows[purpose].state if purpose in self._rows else generator.bit_generator.state
            for purpose, generator in self._generators.items()
        }

    def restore(self, state: Mapping[str, Mapping[str, Any]]) -> None:
        """Goes back to a state. Raises: KeyError when it lacks a stream."""
        for purpose, generator in self._generators.items():
            if purpose in self._rows:
                self._rows[purpose].state = state[purpose]
            else:
                generator.bit_generator.state = state[purpose]


def uniform(random: np.random.Generator, count: int) -> Floats:
    """Numbers in [0, 1)."""
    return random.random(count)


def normal(random: np.random.Generator, count: int) -> Floats:
    """Numbers of a standard normal distribution."""
    return random.standard_normal(count)
