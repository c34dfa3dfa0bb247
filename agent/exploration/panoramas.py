"""The panoramas that local exploration takes: where to begin turning, and what they tell of the heading."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ...world.robot import wrap_angle
from ..estimation.local_filter import LocalPose
from ..perception.compass import turn_between

Panorama = NDArray[np.float32]
"""(4, 16, 16) luminance in [0, 1]: views ahead, left, behind, right in the local frame."""
QUARTER = 0.5 * math.pi
_COMPASS, _PARALLAX = math.radians(0.7), math.radians(200.0)
"""Standard deviation of a turn by views: rad, and rad a meter between the places."""


def view_order(heading: float, after: float | None = None) -> list[int]:
    """The four directions (quarters of the local frame) in the order that turns the robot least.

    heading: where it faces (rad); after: where it will face next (rad), None if that does not matter.
    """

    def turning(first: int, sense: int) -> float:
        last = QUARTER * (first + 3 * sense)
        return abs(wrap_angle(QUARTER * first - heading)) + (
            0.0 if after is None else abs(wrap_angle(after - last))
        )

    first, sense = min(
        ((first, sense) for first in range(4) for sense in (1, -1)), key=lambda way: turning(*way)
    )
    return [(first + sense * k) % 4 for k in range(4)]


class PanoramaSamples:
    """Panoramas with the places (m, local frame) and heading variances (rad^2) where they were taken."""

    def __init__(self) -> None:
        """Empty."""
        self.panoramas: list[Panorama] = []
        self.places: list[tuple[float, float]] = []
        self._variances: list[float] = []

    def add(self, panorama: Panorama, pose: LocalPose) -> None:
        """Keeps a panorama taken at the pose held."""
        self.panoramas.append(panorama)
        self.places.append((pose.x, pose.y))
        self._variances.append(pose.heading_variance)

    def compare(self, panorama: Panorama, pose: LocalPose, field: float, nearest: int, reach: float) -> None:
        """Corrects the heading by turning the panorama against the first and the nearest ones before it.

        field: of the camera's view (rad). nearest: so many are compared, none farther than `reach` (m).
        """
        away = [math.hypot(pose.x - u, pose.y - v) for u, v in self.places]
        for index in self._to_compare(away, nearest):
            if away[index] > reach:
                continue
            turn = turn_between(self.panoramas[index], panorama, field)
            if turn is not None:
                deviation = _COMPASS + _PARALLAX * math.hypot(away[index], pose.place_deviation)
                pose.turn_by_compass(turn.angle, deviation**2 + self._variances[index])

    @staticmethod
    def _to_compare(away: list[float], nearest: int) -> Iterable[int]:
        near = sorted(range(len(away)), key=away.__getitem__)[:nearest]
        return dict.fromkeys([0, *near] if away else [])
