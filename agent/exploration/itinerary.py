"""Which place of the rigid graph comes next: by the strategy, errands to see walls, then home."""

from __future__ import annotations

import math

from ..estimation.landmarks import VANTAGE_POINT
from ..estimation.local_filter import LocalPose
from .rigid_graph import Cell, RigidGraph

_PATIENCE = 12
"""Retreats before obstacles after which exploration goes home."""
_UNSURE = math.radians(2.5)
"""Standard deviation of the heading (rad) with which it does not go home from a place that told nothing."""
_AT_HOME, _HOMINGS = 0.0025, 2
"""Meters from the node that will do, and how often it is driven to again where a fix tells more."""
_BETWEEN_ERRANDS = 3
"""New places to be visited between two errands to see walls."""


class Itinerary:
    """Where a local exploration has been and where it goes next.

    here: the place it stands at or left last. visited: places it was at. given_up: how many could not be
    reached. retreats: how often an obstacle turned it back. errand: a place to see walls from, None for none
    under way. tour: the last places, the node itself at the end; None until all else is done.
    """

    def __init__(self, rigid: RigidGraph, pose: LocalPose, strategy: str, landmarks: bool) -> None:
        """pose: the robot's, kept by others. landmarks: whether walls are looked for on the way."""
        self.rigid = rigid
        self.here: Cell = rigid.center
        self.visited: set[Cell] = {self.here}
        self.given_up = 0
        self.retreats = 0
        self.errand: Cell | None = None
        self.tour: list[Cell] | None = None
        self._pose, self._landmarks = pose, landmarks
        self._queue = rigid.order(strategy)
        self._no_errand_before = 0
        self._homings = 0
        self._seen_from: Cell | None = None

    @property
    def wants_fix(self) -> bool:
        """Whether it came here to look for walls."""
        return self.errand is not None or bool(self.tour)

    @property
    def is_homeward(self) -> bool:
        """Whether nothing is left but to drive to the node itself."""
        return self.tour == [self.rigid.center]

    def arrive(self, cell: Cell) -> None:
        """It has driven to a place."""
        self.rigid.drove(self.here, cell)
        self.here = cell
        self.visited.add(cell)

    def next_cell(self) -> Cell | None:
        """The next place to drive to, a neighbor of this one; None where a fix is wanted, or all is done."""
        if self.retreats > _PATIENCE:
            self._queue.clear()
        self._run_errands()
        if self.errand is not None:
            path = self._way(self.errand)
            return path[0] if path else None
        while self._queue:
            goal = self._queue[0]
            path = None if goal in self.visited else self.rigid.path(self.here, goal)
            if path:
                return path[0]
            self.given_up += goal not in self.visited
            self._queue.pop(0)
        return self._next_of_tour()

    def fixed(self, seen: bool) -> bool:
        """A fix was taken here. seen: whether it saw a known wall.

        Returns False if it shows that the robot is away from the place, and has to drive there again.
        """
        if seen:
            self._seen_from = self.here
        if self.errand is not None:
            self.errand = None
            self._no_errand_before = len(self.visited) + _BETWEEN_ERRANDS
            return True
        if not (self.tour and self._is_at_place()):
            return False
        self.tour.pop(0)
        if not seen:
            self._look_again()
        return True

    def vantage_points(self) -> dict[Cell, float]:
        """Visited places from where walls of two directions can be seen, the nearest to the node last.

        With each the direction (rad, local frame) of the wall there.
        """
        found: dict[Cell, float] = {}
        for mark in self._pose.vantage_points() if self._landmarks else ():
            places = self.rigid.places
            away = {cell: math.dist(places[cell], mark.vantage) for cell in sorted(self.visited)}
            cell = min(away, key=away.__getitem__)
            if away[cell] < VANTAGE_POINT:
                found[cell] = mark.normal
        return found

    def _next_of_tour(self) -> Cell | None:
        if self.tour is None:
            home = self.rigid.center
            self.tour = [*(cell for cell in self.vantage_points() if cell != home), home]
        while self.tour:
            path = self._way(self.tour[0])
            if path:
                return path[0]
            if self.here == self.tour[0] and self.here in self.vantage_points():
                return None
            self.tour.pop(0)
        return None

    def _way(self, goal: Cell) -> list[Cell] | None:
        return self.rigid.path(self.here, goal) or self.rigid.way_back(self.here, goal)

    def _run_errands(self) -> None:
        """Where the pose has become doubtful, looks for walls first: at the nearest place that sees any."""
        early = len(self.visited) < self._no_errand_before
        if self.errand is not None or not self._queue or early or not self._pose.doubtful:
            return
        self.errand = min(
            self.vantage_points(), key=lambda cell: self.rigid.distance(self.here, cell), default=None
        )

    def _look_again(self) -> None:
        """Looking in vain has cost heading: goes by the place that saw a wall last, once."""
        again, self._seen_from = self._seen_from, None
        unsure = self._pose.heading_variance > _UNSURE**2
        if unsure and self.tour and again is not None and again != self.here:
            self.tour.insert(0, again)

    def _is_at_place(self) -> bool:
        """Whether it stands where it should before it turns home, or has tried to often enough."""
        self._homings += 1
        away = math.dist((self._pose.x, self._pose.y), self.rigid.places[self.here])
        return self.here != self.rigid.center or away < _AT_HOME or self._homings > _HOMINGS
