"""The wheel encoders: steps commanded, each miscounted by a little."""

from __future__ import annotations

from typing import Any

from ..noise.random_streams import uniform
from .sensor import Motion, Mounting, Sensor


class Encoders(Sensor):
    """(left, right) steps since the start. Noise: a relative error of each count, uniform in +-encoder."""

    def __init__(self, mounting: Mounting) -> None:
        """Begins at zero."""
        self._noise = mounting.noise.encoder
        self._rows = mounting.streams.rows("encoder", uniform, 2)
        self._counts = (0.0, 0.0)

    def advance(self, motion: Motion) -> None:
        """Counts this tick's steps."""
        left, right = motion.steps
        if self._noise > 0.0:
            first, second = self._rows.row()
            left *= 1.0 + self._noise * (2.0 * first - 1.0)
            right *= 1.0 + self._noise * (2.0 * second - 1.0)
        self._counts = (self._counts[0] + left, self._counts[1] + right)

    def measure(self, motion: Motion) -> tuple[float, float]:
        """The counts."""
        return self._counts

    def state(self) -> Any:
        """The counts."""
        return list(self._counts)

    def restore(self, state: Any) -> None:
        """Goes on from these counts."""
        left, right = state
        self._counts = float(left), float(right)
