"""How walls are followed and what is known of them at a corner: all rooms must agree on it."""

from __future__ import annotations

import math

WALL_DISTANCE = 0.057
"""Meters from the walls at which the robot's center follows them, and so at which corners are nodes."""
_BEYOND = 0.03
"""Meters past a wall's end from where its foot can be seen, sensors turned to and fro."""


def away_from(side: str) -> float:
    """Sign of a turn away from a wall on `side`: +1.0, counter-clockwise, from the right, else -1.0."""
    return 1.0 if side == "right" else -1.0


def walls_at(
    side: str, kind: str, *, square: bool, distance: float
) -> tuple[tuple[float, float, float], ...]:
    """The walls known at a corner: the one followed to it and, if all walls are square, the other one.

    Each as `goals.ExploreLocally` has them: direction to it (rad, local frame), distance (m), standard
    deviation of the direction (rad). side: of the wall followed. kind: of the corner. distance: at which
    walls are followed (m).
    """
    beside = -0.5 * math.pi * away_from(side)
    ahead = math.pi if kind == "convex" else 0.0
    known = ((beside, distance, 0.005), (ahead, distance, 0.008))
    return known if square else known[:1]


def vantage_of(kind: str, walls: tuple[tuple[float, float, float], ...], index: int) -> tuple[float, float]:
    """From where (x, y in m, local frame) a wall known at a corner of that kind can be seen, foot and all.

    The node itself; but at a convex corner the wall followed to it ends behind the node, and the other one
    begins beside it.
    """
    if kind != "convex":
        return (0.0, 0.0)
    normal, distance, _ = walls[0]
    if index == 0:
        return (-distance - _BEYOND, 0.0)
    return (0.0, math.copysign(distance + _BEYOND, normal))
