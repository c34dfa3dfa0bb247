"""The robot's pose while it explores local space: path integration, corrected by walls and views (EKF)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from ...world.robot import Pose, wrap_angle
from ..goals import LocalBelief
from ..perception.wall_scan import SeenWall
from ..walls import vantage_of

_GATE = 16.0
"""Squared standard deviations beyond which a correction is refused."""
_DOUBT, _DOUBT_PLACE = math.radians(4.0), 0.009
"""Standard deviations of the heading (rad) and the place (m) beyond which a pose is doubtful."""
_CLEAR = 0.01
"""Standard deviation (rad) of a wall's direction up to which it is counted on to be seen from there again."""
_FOOT = 0.001
"""Standard deviation (m) of the distance to a wall swept over."""
_HEADING, _BLIND_HEADING = 0.0063, 0.0125
"""Standard deviations (rad) of the heading at a node: beside the wall followed to it, and at a convex corner,
where that wall was last seen 10 cm before."""


@dataclass(slots=True)
class Landmark:
    """A wall kept: normal (rad) and offset (m) of its line in the local frame, with their variances.

    vantage: x, y (m) from where it can be seen, foot and all.
    """

    normal: float
    offset: float
    normal_variance: float
    offset_variance: float
    vantage: tuple[float, float]


class LocalPose:
    """Extended Kalman filter of the pose (m, rad) in the local frame; the heading is not wrapped.

    The state is (x, y, heading, drift_rate): what unequal wheels turn in a meter (rad) is an error that
    goes on in the same way, and known walls tell it too.

    Walls met while the pose is well known become landmarks that correct it later. square: all walls stand at
    right angles to the frame's axes, so that a wall tells the heading even when first met.
    turn_noise: standard deviation (rad) that odometry adds per square root of a radian turned; drive_noise: m
    per square root of a meter driven; drift: rad per square root of a meter driven.
    """

    turn_noise = 0.012
    drive_noise = 0.0035
    drift = 0.05

    def __init__(self, heading: float = 0.0, square: bool = False, drift_rate: float = 0.0) -> None:
        """At the origin, well known, with the heading of a wall just followed.

        drift_rate: standard deviation (rad/m) of what the wheels may still turn unnoticed.
        """
        self.x = self.y = 0.0
        self.heading = heading
        self.drift_rate = 0.0
        self.square = square
        self.landmarks: list[Landmark] = []
        self._xx = self._yy = 1e-6
        self._xy = self._xt = self._yt = 0.0
        self._tt = _HEADING**2
        self._xv = self._yv = self._tv = 0.0
        self._vv = drift_rate * drift_rate

    @property
    def pose(self) -> Pose:
        """The estimate."""
        return Pose(self.x, self.y, self.heading)

    @property
    def heading_variance(self) -> float:
        """Of the heading (rad^2)."""
        return self._tt

    @property
    def place_deviation(self) -> float:
        """Standard deviation of the place (m), in its worse direction at most."""
        return math.sqrt(self._xx + self._yy)

    @property
    def doubtful(self) -> bool:
        """Whether it has become so uncertain that walls should be looked for."""
        return self._tt > _DOUBT**2 or self.place_deviation > _DOUBT_PLACE

    def move(self, distance: float, turn: float) -> None:
        """One tick of path integration (m, rad)."""
        turn += self.drift_rate * distance
        middle = self.heading + 0.5 * turn
        dx, dy = distance * math.cos(middle), distance * math.sin(middle)
        self.x += dx
        self.y += dy
        self.heading += turn
        xt, yt, tt = self._xt, self._yt, self._tt
        drive = self.drive_noise**2 * abs(distance)
        self._xx += -2.0 * dy * xt + dy * dy * tt + drive
        self._yy += 2.0 * dx * yt + dx * dx * tt + drive
        self._xy += dx * xt - dy * yt - dx * dy * tt
        xv, yv, tv = self._xv - dy * self._tv, self._yv + dx * self._tv, self._tv
        self._xt = xt - dy * tt + distance * xv
        self._yt = yt + dx * tt + distance * yv
        self._tt = tt + distance * (2.0 * tv + distance * self._vv)
        self._tt += self.turn_noise**2 * abs(turn) + self.drift**2 * abs(distance)
        self._xv, self._yv, self._tv = xv, yv, tv + distance * self._vv

    def know(
        self, normal: float, distance: float, deviation: float, vantage: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        """Tells a wall known beforehand: normal (rad, local frame), its distance (m) from the origin."""
        self.landmarks.append(Landmark(normal, distance, deviation**2, 0.001**2, vantage))

    def know_corner(self, kind: str, walls: tuple[tuple[float, float, float], ...]) -> None:
        """Tells that it begins at a corner of that kind, with walls as `goals.walls_at` gives them."""
        if kind == "convex":
            self._tt = _BLIND_HEADING**2
        for index, wall in enumerate(walls):
            self.know(*wall, vantage_of(kind, walls, index))

    def vantage_points(self) -> list[Landmark]:
        """Walls of two directions, with vantage points as near to the origin as there are any.

        The nearest comes last, so that a tour of them ends well.
        """
        chosen: list[Landmark] = []
        for mark in sorted(self.landmarks, key=lambda mark: math.hypot(*mark.vantage)):
            if all(abs(math.sin(mark.normal - other.normal)) > 0.7 for other in chosen):
                chosen.append(mark)
        return chosen[::-1]

    def belief(self) -> LocalBelief:
        """All that is held, as plain data."""
        return LocalBelief(
            (self.x, self.y, self.heading, self.drift_rate),
            (self._xx, self._xy, self._xt, self._yy, self._yt, self._tt),
            (self._xv, self._yv, self._tv, self._vv),
            tuple(
                (mark.normal, mark.offset, mark.normal_variance, mark.offset_variance, *mark.vantage)
                for mark in self.landmarks
            ),
            self.square,
        )

    @classmethod
    def of(cls, belief: LocalBelief) -> Self:
        """The pose of a `belief`."""
        pose = cls(belief.pose[2], belief.square)
        pose.x, pose.y = belief.pose[:2]
        pose.drift_rate = belief.pose[3]
        pose._xv, pose._yv, pose._tv, pose._vv = belief.drift_rate
        pose._xx, pose._xy, pose._xt, pose._yy, pose._yt, pose._tt = belief.covariance
        pose.landmarks = [Landmark(*wall[:4], wall[4:]) for wall in belief.walls]
        return pose

    def see(self, wall: SeenWall) -> bool:
        """Corrects the pose by a wall seen from here (normal in the local frame); True if it was known.

        A wall is known if its normal and its place agree with the pose's uncertainty, within 25 deg and 4 cm.
        """
        mark = self._match(wall)
        known = mark is not None
        if mark is None:
            mark = self._keep(wall)
            if mark is None:
                return False
        error = wrap_angle(mark.normal - wall.normal)
        self._update((0.0, 0.0, 1.0), error, mark.normal_variance + wall.deviation**2)
        cosine, sine = math.cos(mark.normal), math.sin(mark.normal)
        offset = self.x * cosine + self.y * sine + wall.distance
        self._update((cosine, sine, 0.0), mark.offset - offset, mark.offset_variance + _FOOT**2)
        clear = wall.deviation < _CLEAR
        if known and clear and math.hypot(self.x, self.y) < math.hypot(*mark.vantage):
            mark.vantage = (self.x, self.y)
        return known

    def turn_by_compass(self, error: float, variance: float) -> None:
        """Corrects the heading by `error` (rad), known from views with `variance` (rad^2)."""
        self._update((0.0, 0.0, 1.0), error, variance)

    def _match(self, wall: SeenWall) -> Landmark | None:
        best: Landmark | None = None
        nearest = math.inf
        for mark in self.landmarks:
            turn = wrap_angle(wall.normal - mark.normal)
            cosine, sine = math.cos(mark.normal), math.sin(mark.normal)
            miss = self.x * cosine + self.y * sine + wall.distance - mark.offset
            if abs(turn) > math.radians(25.0) or abs(miss) > 0.04:
                continue
            score = turn * turn / (self._tt + 0.0003) + miss * miss / (self._along(cosine, sine) + 1e-6)
            if score < nearest:
                best, nearest = mark, score
        return best

    def _keep(self, wall: SeenWall) -> Landmark | None:
        """Keeps a new wall; returns it if its direction is known all the same: where all walls are square."""
        normal, normal_variance = wall.normal, self._tt + wall.deviation**2
        if self.square:
            normal = 0.5 * math.pi * round(wall.normal / (0.5 * math.pi))
            if (wall.normal - normal) ** 2 > _GATE * (self._tt + 0.0001):
                return None
            normal_variance = 0.005**2
        cosine, sine = math.cos(normal), math.sin(normal)
        offset = self.x * cosine + self.y * sine + wall.distance
        along = self._along(cosine, sine)
        mark = Landmark(normal, offset, normal_variance, along + _FOOT**2, (self.x, self.y))
        self.landmarks.append(mark)
        return mark if self.square else None

    def _along(self, cosine: float, sine: float) -> float:
        """Variance (m^2) of the place along a direction."""
        return cosine * cosine * self._xx + 2.0 * cosine * sine * self._xy + sine * sine * self._yy

    def _update(self, row: tuple[float, float, float], error: float, variance: float) -> bool:
        """One scalar correction: `error` is measured minus expected of row . (x, y, heading)."""
        hx, hy, ht = row
        px = self._xx * hx + self._xy * hy + self._xt * ht
        py = self._xy * hx + self._yy * hy + self._yt * ht
        pt = self._xt * hx + self._yt * hy + self._tt * ht
        pv = self._xv * hx + self._yv * hy + self._tv * ht
        total = hx * px + hy * py + ht * pt + variance
        if error * error > _GATE * total:
            return False
        kx, ky, kt, kv = px / total, py / total, pt / total, pv / total
        self.drift_rate += kv * error
        self.x += kx * error
        self.y += ky * error
        self.heading += kt * error
        self._xx -= kx * px
        self._xy -= kx * py
        self._yy -= ky * py
        self._xt -= kx * pt
        self._yt -= ky * pt
        self._tt -= kt * pt
        self._xv -= kx * pv
        self._yv -= ky * pv
        self._tv -= kt * pv
        self._vv -= kv * pv
        return True
