"""How walls are followed, as far as all who have the robot do it must agree."""

from __future__ import annotations

from .goals import FollowFrom

WALL_DISTANCE = 0.057
"""Meters from the walls at which the robot's center follows them, and so at which corners are nodes."""
START_AT = {
    "concave": FollowFrom.CONCAVE,
    "convex": FollowFrom.CONVEX,
    "bend": FollowFrom.WALL,
    "none": FollowFrom.WALL,
}
"""What one stands at who goes on by the same wall: by the kind of `CornerReached`, or of the map's node."""


def toward_free(side: str) -> float:
    """+1.0 where free space is to the left of who follows a wall on `side`, else -1.0: signs of turns."""
    return 1.0 if side == "right" else -1.0
