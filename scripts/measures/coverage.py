"""How much of a world a map covers, by truth: floor share, wall share, places that are in it twice.

The definitions are those of the targets: see `floor_share`, `wall_share` and `duplicates`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...world.geometry import cast, outline_segments
from ...world.robot import EPUCK, Pose, wrap_angle
from ...world.spec import WorldSpec
from .grid import Floor, Mask, Points

KNOWN_WITHIN = 0.2
"""Meters from a known place within which the floor counts as known."""
SAME_PLACE, SAME_WALL = 0.05, math.radians(45.0)
"""Two nodes nearer (m) to one another that face the same wall (rad) are one place."""
_ASIDE = 0.085
"""Meters from a wall at which it counts as followed: its distance, and a little more in corners."""
_SAMPLE = 0.01
_NEAREST = 4
"""How many points of the track are tried for a line of sight to a place on a wall."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """Shares in [0, 1] of the reachable floor and of the walls that bound it; nodes too many."""

    floor_share: float
    wall_share: float
    duplicates: int


def coverage(
    spec: WorldSpec, start: Pose, nodes: Mapping[int, Pose], places: Points, track: Points
) -> Coverage:
    """Measures a map. start: where the robot began. nodes: true poses.

    places: (n, 2) m, true, all that the map knows and that can be driven to. track: (m, 2) m, where arcs were
    truly driven. World frame.
    """
    floor = Floor.of(spec)
    reachable = floor.reachable(start.x, start.y)
    return Coverage(
        floor_share(floor, reachable, places),
        wall_share(spec, floor, reachable, track),
        duplicates(list(nodes.values())),
    )


def floor_share(floor: Floor, reachable: Mask, places: Points) -> float:
    """Share of the reachable floor within KNOWN_WITHIN of one of the places (n, 2) m."""
    if len(places) == 0 or not reachable.any():
        return 0.0
    return float((floor.near(places, KNOWN_WITHIN) & reachable).sum() / reachable.sum())


def wall_share(spec: WorldSpec, floor: Floor, reachable: Mask, track: Points) -> float:
    """Share of the length of the walls that bound the reachable floor that the track (n, 2) m follows."""
    segments = outline_segments([shape.outline() for shape in spec.shapes])
    walls = _bounding(_sampled(segments), floor, reachable)
    if len(walls) == 0 or len(track) == 0:
        return 0.0
    return float(np.mean([_is_followed(wall, track, segments) for wall in walls]))


def _sampled(segments: Points) -> Points:
    """(n, 4): points every centimeter of the segments (m), each with the unit vector along its segment."""
    found = []
    for x0, y0, x1, y1 in segments.tolist():
        length = math.hypot(x1 - x0, y1 - y0)
        if length == 0.0:
            continue
        shares = (np.arange(math.ceil(length / _SAMPLE)) + 0.5) / math.ceil(length / _SAMPLE)
        along = np.broadcast_to(((x1 - x0) / length, (y1 - y0) / length), (len(shares), 2))
        found.append(np.column_stack((x0 + shares * (x1 - x0), y0 + shares * (y1 - y0), along)))
    return np.concatenate(found) if found else np.empty((0, 4))


def _bounding(walls: Points, floor: Floor, reachable: Mask) -> Points:
    """Those of the points (n, 4) whose outer side a robot on the reachable floor can touch, or nearly.

    Outlines run counter-clockwise, so that the outer side is on the right.
    """
    reach = EPUCK.body_radius + 1.5 * floor.cell
    outward = np.stack((walls[:, 3], -walls[:, 2]), 1)
    beside = walls[:, :2] + reach * outward
    rows = np.rint((beside[:, 1] - floor.origin[1]) / floor.cell).astype(int)
    columns = np.rint((beside[:, 0] - floor.origin[0]) / floor.cell).astype(int)
    inside = (rows >= 0) & (rows < reachable.shape[0]) & (columns >= 0) & (columns < reachable.shape[1])
    kept = np.zeros(len(walls), dtype=np.bool_)
    kept[inside] = reachable[rows[inside], columns[inside]]
    return walls[kept]


def _is_followed(wall: Points, track: Points, segments: Points) -> bool:
    """Whether the track passes a point of a wall nearby, on the side that the wall is seen from."""
    place = wall[:2] + 1e-3 * np.array((wall[3], -wall[2]))
    distances = np.hypot(*(track - place).T)
    nearest = np.argsort(distances, kind="stable")[:_NEAREST]
    nearest = nearest[distances[nearest] <= _ASIDE]
    if len(nearest) == 0:
        return False
    rays = track[nearest] - place
    lengths = np.hypot(*rays.T)
    seen = cast(np.broadcast_to(place, rays.shape), rays / np.maximum(lengths, 1e-9)[:, None], segments)
    return bool((seen >= lengths - 1e-6).any())


def duplicates(poses: Sequence[Pose]) -> int:
    """How many of the true poses are places that others are already."""
    distinct: list[Pose] = []
    for pose in poses:
        known = (
            pose.distance_to(other) <= SAME_PLACE
            and abs(wrap_angle(pose.heading - other.heading)) <= SAME_WALL
            for other in distinct
        )
        if not any(known):
            distinct.append(pose)
    return len(poses) - len(distinct)
