"""Whether the wall at the side is round, and how: two filters, and which of them explains the ranges better.

Both are extended Kalman filters of where the robot stands to the wall, fed with the ranges of the side and
the diagonal sensor; one holds the wall to be straight, the other lets it bend. Near by, a round wall is a
parabola.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

_SURE = 7.0
"""Nats by which a round wall must explain the ranges better than a straight one, to be taken for one."""
_PERSISTENT = 0.012
"""Meters over which it must: the edge of a corner looks round over 6 mm."""
_FLAT = 1.5
"""Curvature (1/m) below which a wall that was round is straight again."""
_MOST = 9.0
"""Squared deviations that one range counts at most: it may be of the next wall, or an edge."""
_RANGE_NOISE, _RANGE_SHARE = 0.0003, 0.03
"""Standard deviation of a range: m, and a share of it."""
_TURN_NOISE, _DRIVE_NOISE = 0.002, 0.0001
_BENDING = 9.0
"""How fast a wall may change its curvature: standard deviation, 1/m per root of a meter."""
_CURVATURE = 0.7
"""Standard deviation of a wall's curvature (1/m) before it is seen."""
_TIGHTEST = 25.0
"""Curvature (1/m) of the thinnest pillar, 4 cm in radius."""
_SPREAD = 0.02
"""Standard deviation (rad) with which a straight wall begins where a round one ended."""
_SQUEEZED = 0.2

Hit = tuple[float, float]
"""What a sensor hits: distance from the robot's center (m), bearing from its heading (rad)."""


class _Hypothesis:
    """The robot's distance from the wall (m), its heading away from it (rad), the wall's curvature (1/m)."""

    __slots__ = ("_bends", "_p00", "_p01", "_p02", "_p11", "_p12", "_p22", "angle", "curvature", "distance")

    def __init__(self, distance: float, angle: float, spread: float, bends: bool) -> None:
        self.distance, self.angle, self.curvature = distance, angle, 0.0
        self._bends = bends
        self._p00, self._p11, self._p22 = 1e-5, spread * spread, _CURVATURE**2 if bends else 0.0
        self._p01 = self._p02 = self._p12 = 0.0

    def predict(self, driven: float, turned: float) -> None:
        """One tick of path integration: m, and rad away from the wall."""
        along = driven / max(1.0 + self.curvature * self.distance, _SQUEEZED)
        self.distance += driven * math.sin(self.angle + 0.5 * turned)
        self.angle += turned + self.curvature * along
        p11, p12, p22 = self._p11, self._p12, self._p22
        self._p00 += driven * (2.0 * self._p01 + driven * p11) + _DRIVE_NOISE**2
        self._p01 += driven * p11 + along * (self._p02 + driven * p12)
        self._p02 += driven * p12
        self._p11 = p11 + along * (2.0 * p12 + along * p22) + _TURN_NOISE**2
        self._p12 = p12 + along * p22
        if self._bends:
            self._p22 = p22 + _BENDING**2 * abs(driven)

    def see(self, reach: float, bearing: float, noise: float) -> float:
        """Takes a hit with its standard deviation (m); returns its log likelihood, but for a constant."""
        distance, curvature = self.distance, self.curvature
        cosine, sine = math.cos(self.angle + bearing), math.sin(self.angle + bearing)
        square = sine * sine - 2.0 * curvature * cosine * cosine * distance
        if sine > -0.05 or square < 1e-4:
            return -0.5 * _MOST  # it should have missed the wall
        # The nearer t with distance + t sine = -curvature (t cosine)^2 / 2; for straight walls too.
        root = math.sqrt(square)
        below = root - sine
        expected = 2.0 * distance / below
        share = expected / below
        h0 = 2.0 / below + share * curvature * cosine * cosine / root
        h1 = share * (cosine - sine * cosine * (1.0 + 2.0 * curvature * distance) / root)
        h2 = share * cosine * cosine * distance / root
        g0 = self._p00 * h0 + self._p01 * h1 + self._p02 * h2
        g1 = self._p01 * h0 + self._p11 * h1 + self._p12 * h2
        g2 = self._p02 * h0 + self._p12 * h1 + self._p22 * h2
        variance = h0 * g0 + h1 * g1 + h2 * g2 + noise * noise
        error = reach - expected
        z = error * error / variance
        if z <= _MOST:
            gain = error / variance
            self.distance += gain * g0
            self.angle += gain * g1
            self.curvature = min(max(curvature + gain * g2, -_TIGHTEST), _TIGHTEST)
            self._p00 -= g0 * g0 / variance
            self._p01 -= g0 * g1 / variance
            self._p02 -= g0 * g2 / variance
            self._p11 -= g1 * g1 / variance
            self._p12 -= g1 * g2 / variance
            self._p22 -= g2 * g2 / variance
        return -0.5 * (min(z, _MOST) + math.log(variance / (noise * noise)))


class CurvedWall:
    """Follows the wall at the side, frame of `SideView`, and says when it is round. driven: m so far."""

    def __init__(self, distance: float, angle: float, spread: float) -> None:
        """distance: m, expected. angle: rad, away from the wall is positive. spread: its deviation (rad)."""
        self._round = _Hypothesis(distance, angle, spread, True)
        self._straight = _Hypothesis(distance, angle, spread, False)
        self._evidence = self._convinced = 0.0
        self.driven = 0.0
        self.is_round = False

    @property
    def distance(self) -> float:
        """Meters from the robot's center."""
        return self._round.distance

    @property
    def angle(self) -> float:
        """The robot's heading from the wall's direction here (rad), positive when it points away."""
        return self._round.angle

    @property
    def bend(self) -> float:
        """By how much (rad) the wall turns away for each meter that the robot drives along it."""
        wall = self._round
        return wall.curvature / max(1.0 + wall.curvature * wall.distance, _SQUEEZED)

    def predict(self, driven: float, turned: float) -> None:
        """One tick of path integration: driven (m), turned (rad, away from the wall is positive)."""
        self._round.predict(driven, turned)
        self._straight.predict(driven, turned)
        self.driven += driven
        self._convinced = self._convinced + driven if self._evidence > _SURE else 0.0

    def see(self, hits: Iterable[Hit]) -> None:
        """Takes what the side and the diagonal sensor hit in this tick."""
        for reach, bearing in hits:
            noise = _RANGE_NOISE + _RANGE_SHARE * abs(reach - 0.035)
            gained = self._round.see(reach, bearing, noise) - self._straight.see(reach, bearing, noise)
            self._evidence = max(0.0, self._evidence + gained)
        if not self.is_round:
            self.is_round = self._convinced > _PERSISTENT
        elif abs(self._round.curvature) < _FLAT:
            self.is_round = False
            self._straight = _Hypothesis(self.distance, self.angle, _SPREAD, False)
            self._evidence = self._convinced = 0.0
