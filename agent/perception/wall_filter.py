"""The wall at the robot's side, through steps and bends.

The filter of one straight wall refuses what does not lie on it. What it refuses is not thrown away: a rival
filter follows it, and takes the wall's place once it has proved to be a wall of its own.
"""

from __future__ import annotations

import math
from collections import deque

from .round_wall import CurvedWall, Hit
from .side_view import WallFilter

_STEP = 0.006
"""Meters by which what is abreast must be elsewhere than the wall."""
_OFF = 0.003
"""Meters beyond which what is abreast is not the wall; less, and the diagonal sensor alone disagrees."""
_NEARER, _FARTHER = 5, 15
"""Ticks in a row in which the wall must seem elsewhere, nearer or farther, before it is taken to be there."""
_STEP_SPREAD = 0.06
"""Standard deviation (rad) of a wall's direction beyond a step in it."""
_AHEAD = 0.03
"""Radians by which a line must lead toward the robot's way to be mixed with what is ahead."""

_KEPT = 60
"""Ticks that are gone through again once the wall is suspected to be round."""
_RANGE = 0.0008
"""Standard deviation (m) of what the side sensor tells of a wall's distance."""
_RECENT, _BIASED = 0.1, 0.9
"""How much the last tick counts in the mean of how far off the wall is (in deviations), and what is odd."""
_EDGE, _STEEP = 0.012, 0.9
"""Over so many meters, an edge lets what is abreast recede by this share of them, or more."""
_BEYOND, _LEAST_BEYOND = 0.003, 5
"""How much farther (m) than the wall what is abreast must be to be beyond its edge, and how often."""
_GENTLE, _STEEPEST = math.tan(math.radians(27.0)), math.tan(math.radians(70.0))
"""How fast it recedes (m a meter) beyond a blunt corner: less is no corner, more as good as a right angle."""
_CLEARED = 0.1
"""Meters after which a wall that was suspected and is not round is no longer."""


class SideWall:
    """Where the robot stands to the wall it follows. Frame of `SideView`: the wall is on the right."""

    __slots__ = ("_bends", "_bias", "_curved", "_filter", "_past", "_refused", "_rival")

    def __init__(self, distance: float, angle: float = 0.0, spread: float = 0.1) -> None:
        """distance: m, expected. angle: rad, away from the wall is positive. spread: its deviation (rad)."""
        self._filter = WallFilter(distance, angle, spread)
        self._forget()
        self._rival: WallFilter | None = None
        self._refused = 0

    @property
    def distance(self) -> float:
        """Meters from the robot's center."""
        return self._filter.distance

    @property
    def angle(self) -> float:
        """The robot's heading from the wall's direction (rad), positive when it points away from the wall."""
        return self._filter.angle

    @property
    def samples(self) -> int:
        """How many lines of it were taken."""
        return self._filter.samples

    def predict(self, driven: float, turned: float) -> None:
        """One tick of path integration: driven (m), turned (rad, away from the wall is positive)."""
        wall = self._filter
        self._past.append((driven, turned, (), wall.distance, wall.angle))
        wall.predict(driven, turned)
        if self._curved is not None:
            self._curved.predict(driven, turned)
        if self._rival is not None:
            self._rival.predict(driven, turned)

    def meet(self, line: tuple[float, float]) -> None:
        """Takes a line for the wall, whatever was known before."""
        self._filter = WallFilter(line[0], line[1], 0.03)
        self._forget()
        self._rival, self._refused = None, 0

    def _forget(self) -> None:
        """Another wall: nothing is known of its shape."""
        self._curved: CurvedWall | None = None
        self._bias, self._bends = 0.0, False
        self._past: deque[tuple[float, float, tuple[Hit, ...], float, float]] = deque(maxlen=_KEPT)

    @property
    def bend(self) -> float:
        """By how much (rad) the wall turns away for each meter driven along it; 0 unless it is round."""
        curved = self._curved
        return curved.bend if curved is not None and curved.is_round else 0.0

    def sweep(self, hits: tuple[Hit, ...], reach: float) -> bool:
        """Takes what the sensors hit in this tick; whether the wall is round: then there is no line to see.

        reach: m from the center to what is abreast.
        """
        wall = self._filter
        if self._past:
            driven, turned, _, distance, angle = self._past[-1]
            self._past[-1] = (driven, turned, hits, distance, angle)
        off = (reach * math.cos(wall.angle) - wall.distance) / _RANGE
        self._bias += _RECENT * (max(-3.0, min(3.0, off)) - self._bias)
        curved = self._curved
        if curved is None:
            if abs(self._bias) < _BIASED:
                return False
            curved = self._curved = self._suspect()
        else:
            curved.see(hits)
        if not curved.is_round or self._passed_an_edge():
            if curved.driven > _CLEARED or curved.is_round:
                self._curved = None
            return False
        samples = wall.samples
        self._filter = WallFilter(curved.distance, curved.angle, _STEP_SPREAD)
        self._filter.samples = samples + 1
        self._rival, self._refused = None, 0
        return True

    def edge(self) -> tuple[float, float] | None:
        """A blunt corner's edge that the side sensor has just passed, by how it saw the wall beyond recede.

        (turn, past): how far the boundary turns there (rad), how far past the edge the robot is (m). None if
        nothing beyond was seen, as at a right angle.
        """
        driven, beyond = 0.0, []
        for step, _, hits, distance, _ in reversed(self._past):
            if hits:
                if hits[0][0] - distance < _BEYOND:
                    break
                beyond.append((driven, hits[0][0] - distance))
            driven -= step
        if len(beyond) < _LEAST_BEYOND:
            return None
        middle = sum(at for at, _ in beyond) / len(beyond)
        mean = sum(far for _, far in beyond) / len(beyond)
        spread = sum((at - middle) ** 2 for at, _ in beyond)
        slope = sum((at - middle) * far for at, far in beyond) / max(spread, 1e-9)
        if not _GENTLE < slope < _STEEPEST:
            return None
        return math.atan(slope), mean / slope - middle

    def _passed_an_edge(self) -> bool:
        """Whether what is abreast fell away at once, as beyond an edge; a round wall begins gently."""
        if self._bends:
            return False
        driven, seen = 0.0, []
        for step, _, hits, _, _ in self._past:
            driven += step
            if hits:
                seen.append((driven, hits[0][0]))
        k = 0
        for at, reach in seen:
            while seen[k][0] < at - _EDGE:
                k += 1
            if reach - seen[k][1] > _STEEP * _EDGE:
                return True
        self._bends = True
        return False

    def _suspect(self) -> CurvedWall:
        """Goes through the last ticks again, for a wall that may be round."""
        _, _, _, distance, angle = self._past[0]
        curved = CurvedWall(distance, angle, _STEP_SPREAD)
        for driven, turned, hits, _, _ in self._past:
            curved.predict(driven, turned)
            curved.see(hits)
        curved.driven = 0.0
        return curved

    def see(self, line: tuple[float, float] | None, reach: float, ahead: bool) -> bool:
        """Takes one tick's sight of the wall; whether that told its direction.

        line: as `SideView.side_wall` gives it. reach: m from the center to what is abreast. ahead: whether
        a front sensor on this side hits something.
        """
        wall = self._filter
        abreast = reach * math.cos(wall.angle)
        if line is None:
            wall.correct_distance(abreast)
            return False
        if ahead and line[1] < wall.angle - _AHEAD and abs(abreast - wall.distance) < _OFF:
            # The diagonal sensor hits the next wall already, the side sensor still this one.
            wall.correct_distance(abreast)
            return False
        if wall.correct(line):
            self._rival, self._refused = None, 0
        elif wall.samples < 3:
            self.meet(line)
        else:
            self._refuse(line, abreast)
            return self._filter is not wall
        return True

    def _refuse(self, line: tuple[float, float], abreast: float) -> None:
        """The line seen is not the wall's: a corner ahead, a step in the wall, or the wall bends."""
        wall = self._filter
        step = abreast - wall.distance
        self._challenge(line, step)
        self._refused = self._refused + 1 if abs(step) > _STEP else 0
        if self._refused <= (_FARTHER if step > 0.0 else _NEARER):
            return
        # It is elsewhere, and no line shows its direction: as before, if less surely.
        self._filter = WallFilter(abreast, wall.angle, _STEP_SPREAD)
        self._filter.samples = wall.samples
        self._refused = 0

    def _challenge(self, line: tuple[float, float], step: float) -> None:
        if abs(step) < _OFF:
            self._rival = None
            return
        rival = self._rival
        if rival is None or not rival.correct(line):
            rival = self._rival = WallFilter(line[0], line[1], 0.05)
        elif rival.samples >= (_FARTHER if step > 0.0 else _NEARER):
            rival.samples = self._filter.samples
            self._filter, self._rival, self._refused = rival, None, -_FARTHER
