"""The wall at the robot's side, through steps and bends.

The filter of one straight wall refuses what does not lie on it. What it refuses is not thrown away: a rival
filter follows it, and takes the wall's place once it has proved to be a wall of its own.
"""

from __future__ import annotations

import math

from .surroundings import WallFilter

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


class SideWall:
    """Where the robot stands to the wall it follows. Frame of `SideView`: the wall is on the right."""

    __slots__ = ("_filter", "_refused", "_rival")

    def __init__(self, distance: float, angle: float = 0.0, spread: float = 0.1) -> None:
        """distance: m, expected. angle: rad, away from the wall is positive. spread: its deviation (rad)."""
        self._filter = WallFilter(distance, angle, spread)
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
        self._filter.predict(driven, turned)
        if self._rival is not None:
            self._rival.predict(driven, turned)

    def meet(self, line: tuple[float, float]) -> None:
        """Takes a line for the wall, whatever was known before."""
        self._filter = WallFilter(line[0], line[1], 0.03)
        self._rival, self._refused = None, 0

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
