"""How good a trip was: success weighted by path length (Anderson et al. 2018)."""

from __future__ import annotations

from ...world.geometry import Point
from ...world.spec import WorldSpec
from .grid import Floor, shortest

MARGIN = 0.01
"""Meters that the disc of the shortest way is wider than the robot."""


def shortest_way(spec: WorldSpec, start: Point, goal: Point) -> float | None:
    """Length (m) of the true shortest way of a disc as wide as the robot plus 1 cm; None if there is none."""
    return shortest(Floor.of(spec, MARGIN), start, goal)


def spl(reached: bool, shortest_m: float | None, driven_m: float) -> float:
    """Success x shortest / max(shortest, driven), of one trip; 0 for one that failed or has no way."""
    if not reached or shortest_m is None:
        return 0.0
    longer = max(shortest_m, driven_m)
    return shortest_m / longer if longer > 0.0 else 1.0
