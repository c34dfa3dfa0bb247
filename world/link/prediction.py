"""Where the wheels will be once all commands on their way have come: a Smith predictor for the step counters.

A command reaches the wheels, and the count that shows it comes back, a delay later. What was sent within that
delay is added to what was counted. The delay is learned from how counts follow commands.
"""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Steps: TypeAlias = tuple[float, float]

LONGEST, GRAIN = 0.4, 0.016
"""The longest delay (s) that is thought of, and how finely they are told apart."""
MEMORY = 0.97
"""What a misfit still counts for, one packet later."""
BETTER = 0.8
"""Share of the misfit of the present delay below which another one takes its place."""
STEADY = 0.1
"""Seconds between two packets above which the link stalled: that says nothing of its usual delay."""
KEPT = 256
"""Commands that are remembered: several seconds of them."""


class Predictor:
    """Told of every command and every count, at their times (s); says where the wheels will be."""

    def __init__(self) -> None:
        """At rest at zero."""
        self.delay = 0.0
        self.counts: Steps = (0.0, 0.0)
        self._at: float | None = None
        self._stalled = 0.0
        self._sent: deque[tuple[float, float, float, float, float]] = deque(maxlen=KEPT)
        self._candidates = np.arange(0.0, LONGEST + GRAIN / 2, GRAIN)
        self._misfits = np.zeros(len(self._candidates))

    def sent(self, time: float, left: float, right: float) -> None:
        """Speeds (steps/s) were sent, which hold until the next."""
        done = self._commanded(np.array([time]))[0] if self._sent else (0.0, 0.0)
        self._sent.append((time, left, right, float(done[0]), float(done[1])))

    def counted(self, time: float, left: float, right: float) -> None:
        """The counters, without their wrapping, were received at `time`."""
        if self._at is not None and self._sent and time - self._at < STEADY and time > self._stalled:
            self._learn(self._at, time, (left - self.counts[0], right - self.counts[1]))
        if self._at is not None and time - self._at >= STEADY:
            self._stalled = time + LONGEST  # commands that waited come late
        self._at, self.counts = time, (left, right)

    def now(self, time: float) -> Steps:
        """Left and right counters as they will be when all that was sent until `time` is done."""
        if self._at is None or not self._sent:
            return self.counts
        before, after = self._commanded(np.array([self._at - self.delay, time]))
        return self.counts[0] + float(after[0] - before[0]), self.counts[1] + float(after[1] - before[1])

    def _learn(self, before: float, now: float, moved: Steps) -> None:
        """Which delay would have had the commands move the wheels as they did."""
        expected = self._commanded(now - self._candidates) - self._commanded(before - self._candidates)
        self._misfits *= MEMORY
        self._misfits += ((expected - np.array(moved)) ** 2).sum(axis=1)
        best = int(self._misfits.argmin())
        present = round(self.delay / GRAIN)
        if self._misfits[best] < BETTER * self._misfits[present]:
            self.delay = float(self._candidates[best])

    def _commanded(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 2): steps that were asked for until each of the times, were there no delay."""
        sent = np.array(self._sent)
        index = np.maximum(np.searchsorted(sent[:, 0], times, side="right") - 1, 0)
        since = np.maximum(times - sent[index, 0], 0.0)[:, None]
        moved: NDArray[np.float64] = sent[index, 3:5] + since * sent[index, 1:3]
        return moved
