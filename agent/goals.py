"""What mapping, navigation and missions ask of behaviors: plain data, so that nobody imports a behavior."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any

from ..world.robot import Pose

Side = Annotated[str, ("right", "left")]
"""Where the wall is that a robot follows."""


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


START_AT = {
    "concave": FollowFrom.CONCAVE,
    "convex": FollowFrom.CONVEX,
    "bend": FollowFrom.WALL,
    "none": FollowFrom.WALL,
}
"""What one stands at who goes on by the same wall: by the kind of `CornerReached`, or of the map's node."""


@dataclass(frozen=True, slots=True)
class Follow:
    """Follow the wall on `side` ("right" or "left"); `start`: what the robot stands at.

    turn: rad, counter-clockwise, by which to begin at a corner; None is a quarter to where it must lead.
    reach: m of path after which it ends beside the wall, None to follow on until it is stopped.
    """

    side: Side
    start: FollowFrom = FollowFrom.SEARCH
    turn: float | None = None
    reach: float | None = None


@dataclass(frozen=True, slots=True)
class ExploreLocally:
    """Explore the space around the node the robot stands at; the local frame's x axis is the entry heading.

    strategy: "rows" or "columns". heading: the robot's own, rad, in that frame. walls: those known already,
    as (direction to it in rad, distance from the node in m, standard deviation of the direction in rad).
    square: whether all walls are known to stand at right angles to these. corner: of the node; at a convex
    one no wall is near. points: obstacles known already (m, the node's frame), such as that corner's edge.
    drift_rate: standard deviation (rad/m) of what unequal wheels may turn unnoticed.
    """

    strategy: Annotated[str, ("rows", "columns")] = "rows"
    heading: float = 0.0
    walls: tuple[tuple[float, float, float], ...] = ()
    square: bool = False
    corner: str = "concave"
    points: tuple[tuple[float, float], ...] = ()
    drift_rate: float = 0.0


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
class ReacquireCorner:
    """Back off along the wall on `side` and come to the corner again, of that `kind`.

    room: how far (m) the wall just followed is known to lead back.
    """

    side: Side
    kind: Annotated[str, ("concave", "convex")]
    room: float


@dataclass(frozen=True, slots=True)
class Crossing:
    """How a foray leads from a node across open space to the next (m, rad; turns counter-clockwise).

    offset: along the wall that leaves the node, to where the foray sets out. turn: from that wall to the way
    across. distance: straight on, until a wall is near. wall: from the way across to the wall met there, as
    it is followed. join: along that wall to the corner that is the next node.
    """

    offset: float
    turn: float
    distance: float
    wall: float
    join: float


@dataclass(frozen=True, slots=True)
class Leg:
    """One arc to drive: follow the wall on `side` to `target`, `distance` m on, a corner of kind `corner`.

    turn: rad, counter-clockwise, to turn in place before. start: what the robot then stands at, None to go
    on following through the corner it has just reached. bend: rad, counter-clockwise, by which the boundary
    turns at the corner it starts at. crossing: of a foray; then `distance` is of all its parts. blunt:
    whether that corner turns so little that it may be met one time and not the next.
    """

    source: int
    target: int
    side: str
    distance: float
    corner: str
    turn: float = 0.0
    start: FollowFrom | None = None
    bend: float | None = None
    crossing: Crossing | None = None
    blunt: bool = False

    @property
    def kind(self) -> str:
        """The kind of the arc: the side, or foray."""
        return self.side if self.crossing is None else "foray"


@dataclass(frozen=True, slots=True)
class GoAlong:
    """Drive these legs one after the other, then turn in place by `face` (rad, counter-clockwise)."""

    legs: tuple[Leg, ...]
    face: float = 0.0


@dataclass(frozen=True, slots=True)
class LegDriven:
    """A leg as it was driven. distance: m. recognized: whether its end was known by its corner.

    foray: whether it led across open space, not along a wall all the way.
    """

    source: int
    target: int
    side: str
    distance: float
    recognized: bool
    foray: bool = False

    @property
    def kind(self) -> str:
        """The kind of the arc: the side, or foray."""
        return "foray" if self.foray else self.side


@dataclass(frozen=True, slots=True)
class LocalBelief:
    """What `estimation.local_filter.LocalPose` holds, so that one behavior can go on for another.

    pose: x, y (m), heading (rad), local frame, drift_rate (rad/m). covariance: xx, xy, xt, yy, yt, tt;
    drift_rate: its covariances with x, y and heading, and its variance. walls: each as normal
    (rad), offset (m), their variances, and a vantage point's x, y (m). square: all walls stand square.
    """

    pose: tuple[float, float, float, float]
    covariance: tuple[float, float, float, float, float, float]
    drift_rate: tuple[float, float, float, float]
    walls: tuple[tuple[float, float, float, float, float, float], ...] = ()
    square: bool = False


@dataclass(frozen=True, slots=True)
class DrivePath:
    """Drive through these places (m, in the frame that has the robot's pose `start`), then face `heading`.

    belief: what is known of pose and walls, in place of `start`; then the walls that the robot's turns sweep
    correct the pose. fix: whether to look for those walls at the end, turning to and fro.
    """

    places: tuple[tuple[float, float], ...]
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    heading: float | None = None
    belief: LocalBelief | None = None
    fix: bool = False


@dataclass(frozen=True, slots=True)
class PlacesDriven:
    """How `DrivePath` went. reached: how many of the places; pose: where it ended, same frame; belief: what
    is known at the end, if the goal had one."""

    reached: int
    pose: Pose
    belief: LocalBelief | None = None


@dataclass(frozen=True, slots=True)
class LookAround:
    """Turn in place by `turn` (rad, counter-clockwise); then, if `views`, take a four-directional image.

    The image's views are ahead, left, behind and right of where the robot points after the turn; it ends
    pointing there again.
    """

    turn: float = 0.0
    views: bool = True


@dataclass(frozen=True, slots=True)
class AlignToWall:
    """Turn in place until the wall on `side` ("right" or "left") is parallel."""

    side: Side = "right"


@dataclass(frozen=True, slots=True)
class Foray:
    """Drive straight across open space until a wall is near, at most `max_distance` (m).

    turn: rad, counter-clockwise, to turn in place before.
    """

    turn: float = 0.0
    max_distance: float = 3.0

    def __post_init__(self) -> None:
        """Raises: ValueError if it leads nowhere."""
        if not self.max_distance > 0.0:
            raise ValueError(f"max_distance must be above 0, not {self.max_distance!r}")


@dataclass(frozen=True, slots=True)
class Dock:
    """Come to rest at `pose` (m, rad, path-integrated frame), trimmed by the walls that are known there.

    side: where a wall is parallel to the final heading, "right", "left" or None. wall_ahead: distance (m)
    of the center from the wall ahead in the docked pose, None where there is none.
    """

    pose: Pose
    side: Side | None = None
    wall_ahead: float | None = None
