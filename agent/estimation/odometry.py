"""Path integration: where the robot is, by counting wheel steps (section 3.3, eq. 3.1 to 3.7)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...world.robot import Pose, RobotGeometry, wrap_angle

MISMATCH = 0.0122
"""Standard deviation of the relative difference of the diameters of two wheels that nothing is known of."""


class PathIntegrator:
    """Integrates encoder steps to a pose in the frame of where it started.

    mismatch: relative difference of the wheels' diameters, (right - left) / mean, as far as it is known;
    0 takes the wheels as equal (profile `thesis`). mismatch_deviation: standard deviation of what is not
    known of it, at first that of +-2.1 % uniform.
    """

    def __init__(self, geometry: RobotGeometry, pose: Pose = Pose(), mismatch: float = 0.0) -> None:  # noqa: B008
        """Starts at `pose`; the first `update` only takes the encoders' zero."""
        self._step = geometry.distance_per_step
        self._track = geometry.track
        self.mismatch = mismatch
        self.mismatch_deviation = MISMATCH
        self.x, self.y, self.heading = pose.x, pose.y, pose.heading
        self.distance = 0.0
        self.turn = 0.0
        self.travelled = 0.0
        self._previous: tuple[float, float] | None = None

    @property
    def pose(self) -> Pose:
        """The integrated pose: m, rad in (-pi, pi]."""
        return Pose(self.x, self.y, wrap_angle(self.heading))

    def update(self, encoders: tuple[float, float]) -> None:
        """Adds one tick's steps. Sets `distance` (m) and `turn` (rad) to this tick's, signed.

        The heading in the middle of the tick is used for the displacement; eq. 3.6 takes the one at its
        start, which differs by half a tick's turn.
        """
        previous, self._previous = self._previous, encoders
        if previous is None:
            self.distance = self.turn = 0.0
            return
        left = (encoders[0] - previous[0]) * self._step * (1.0 - 0.5 * self.mismatch)
        right = (encoders[1] - previous[1]) * self._step * (1.0 + 0.5 * self.mismatch)
        self.distance = 0.5 * (left + right)
        self.turn = (right - left) / self._track
        middle = self.heading + 0.5 * self.turn
        self.x += self.distance * math.cos(middle)
        self.y += self.distance * math.sin(middle)
        self.heading += self.turn
        self.travelled += self.distance

    @property
    def drift_rate(self) -> float:
        """Standard deviation (rad/m) of what unequal wheels turn unnoticed."""
        return self.mismatch_deviation / self._track

    def reset(self, pose: Pose) -> None:
        """Moves the estimate to `pose` without touching the distance travelled."""
        self.x, self.y, self.heading = pose.x, pose.y, pose.heading

    def state(self) -> dict[str, Any]:
        """All that changes, as JSON."""
        return {
            "pose": [self.x, self.y, self.heading],
            "travelled": self.travelled,
            "mismatch": [self.mismatch, self.mismatch_deviation],
            "encoders": None if self._previous is None else list(self._previous),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        self.x, self.y, self.heading = state["pose"]
        self.travelled = state["travelled"]
        self.mismatch, self.mismatch_deviation = state["mismatch"]
        encoders = state["encoders"]
        self._previous = None if encoders is None else (encoders[0], encoders[1])
