"""What is drawn of a map, as plain values."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...world.robot import EPUCK, Pose
from ...world.spec import Shape

LEAST_MARGIN = EPUCK.body_radius + 0.01
"""Meters around what is drawn, at least: the shaded free space is as much wider than its units."""


@dataclass(frozen=True, slots=True)
class Lattice:
    """A metric SOM: weights (units, 2) m in the node's frame, its kept edges, and which units were hit.

    blocked: those of the edges that were found blocked.
    """

    weights: NDArray[np.float64]
    edges: Sequence[tuple[int, int]]
    hit: NDArray[np.bool_]
    blocked: Collection[tuple[int, int]] = frozenset()


@dataclass(frozen=True, slots=True)
class ArcLine:
    """An arc to draw, from node to node, with its distance (m) as the robot measured it."""

    start: int
    end: int
    distance: float
    foray: bool = False
    blocked: bool = False


@dataclass(frozen=True, slots=True)
class Drawing:
    """Everything that is drawn, in one frame (m): the world's where the truth is known.

    nodes: pose of each, heading = entry heading. corners: node -> `concave`, `convex` or `none`. track:
    (n, 2) m, the driven path, empty if not known.
    """

    title: str
    nodes: Mapping[int, Pose]
    arcs: Sequence[ArcLine] = ()
    lattices: Mapping[int, Lattice] = field(default_factory=dict)
    shapes: Sequence[Shape] = ()
    track: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    corners: Mapping[int, str] = field(default_factory=dict)


def placed(weights: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    """Points (n, 2) m of a node's frame in the frame of its pose."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    moved: NDArray[np.float64] = weights @ np.array([[cosine, sine], [-sine, cosine]]) + (pose.x, pose.y)
    return moved


def extent(drawing: Drawing) -> tuple[float, float, float, float]:
    """Least and largest x and y (m) of what is drawn, with a margin."""
    places = [np.array([[pose.x, pose.y] for pose in drawing.nodes.values()]).reshape(-1, 2), drawing.track]
    places += [np.array(shape.outline()) for shape in drawing.shapes]
    places += [placed(lattice.weights, drawing.nodes[node]) for node, lattice in drawing.lattices.items()]
    points = np.concatenate([place[np.isfinite(place).all(axis=1)] for place in places])
    if not len(points):
        points = np.zeros((1, 2))
    least, most = points.min(axis=0), points.max(axis=0)
    margin = max(0.03 * float((most - least).max()), LEAST_MARGIN)
    return least[0] - margin, most[0] + margin, least[1] - margin, most[1] + margin
