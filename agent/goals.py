"""What mapping, navigation and missions ask of behaviors: plain data, so that nobody imports a behavior."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any


class FollowFrom(Enum):
    """Where a wall follower begins."""

    SEARCH = "search"
    """Anywhere: look for a wall first."""
    WALL = "wall"
    """Beside the wall already, parallel to it."""
    CONCAVE = "concave"
    """At a concave corner, facing the wall ahead: turn away from it."""
    CONVEX = "convex"
    """At a convex corner, the wall's end behind: turn around it."""
    GAP = "gap"
    """Heading along a wall that begins a little ahead, as after the turn at a convex corner."""


@dataclass(frozen=True, slots=True)
class Follow:
    """Follow the wall on `side` ("right" or "left"); `start`: what the robot stands at."""

    side: str
    start: FollowFrom = FollowFrom.SEARCH


@dataclass(frozen=True, slots=True)
class ExploreLocally:
    """Explore the space around the node the robot stands at, heading along the local frame's x axis.

    strategy: "rows" or "columns".
    """

    strategy: str = "rows"


@dataclass(frozen=True, slots=True)
class LocalSamples:
    """What local exploration brought home, in the node's local frame (x: entry heading).

    positions: (n, 2) m. panorama_positions: (k, 2) m. panoramas: (k, 4, 16, 16) in [0, 1].
    visited, unreachable: how many of the rigid graph's nodes were driven to, and given up.
    """

    positions: Any
    panorama_positions: Any
    panoramas: Any
    visited: int
    unreachable: int


@dataclass(frozen=True, slots=True)
class TurnBy:
    """Turn in place by `angle` (rad, counter-clockwise), by path integration."""

    angle: float


@dataclass(frozen=True, slots=True)
class DriveBy:
    """Drive `distance` (m, negative: backwards) straight on, by path integration."""

    distance: float
