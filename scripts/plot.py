"""Draws a map: walls, the path truly driven, nodes, arcs and the metric SOMs, to PNG, SVG or PDF.

The same content gives the same bytes: no dates, no random ids. Only this module draws; it needs no display.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.patches import Polygon as PolygonPatch
from numpy.typing import NDArray

from ..world.geometry import outline
from ..world.robot import Pose
from ..world.spec import Shape

WALL, PATH, ARC, LATTICE, NODE = "#3b4252", "#d08770", "#2e7d32", "#5e81ac", "#bf616a"
DOTS_PER_INCH = 130
NO_DATES = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None, "Producer": None}}


@dataclass(frozen=True, slots=True)
class Lattice:
    """A metric SOM: weights (units, 2) m in the node's frame, its kept edges, and which units were hit."""

    weights: NDArray[np.float64]
    edges: Sequence[tuple[int, int]]
    hit: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class ArcLine:
    """An arc to draw, from node to node, with its distance (m) as the robot measured it."""

    start: int
    end: int
    distance: float


@dataclass(frozen=True, slots=True)
class Drawing:
    """Everything that is drawn, in one frame (m): the world's where the truth is known.

    nodes: pose of each, heading = entry heading. track: (n, 2) m, the driven path, empty if not known.
    """

    title: str
    nodes: Mapping[int, Pose]
    arcs: Sequence[ArcLine] = ()
    lattices: Mapping[int, Lattice] = field(default_factory=dict)
    shapes: Sequence[Shape] = ()
    track: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    labels: Mapping[int, str] = field(default_factory=dict)


def placed(weights: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    """Points (n, 2) m of a node's frame in the frame of its pose."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    moved: NDArray[np.float64] = weights @ np.array([[cosine, sine], [-sine, cosine]]) + (pose.x, pose.y)
    return moved


def draw_lattice(axes: Axes, lattice: Lattice, pose: Pose) -> None:
    """Draws one metric SOM: kept edges as lines, units as dots, hollow where no sample fell."""
    points = placed(lattice.weights, pose)
    lines = [(points[a], points[b]) for a, b in lattice.edges]
    axes.add_collection(LineCollection(lines, colors=LATTICE, linewidths=0.7, zorder=3))
    for hit, color in ((True, LATTICE), (False, "white")):
        chosen = points[lattice.hit == hit]
        axes.scatter(chosen[:, 0], chosen[:, 1], s=5, c=color, edgecolors=LATTICE, linewidths=0.4, zorder=4)


def draw_arcs(axes: Axes, drawing: Drawing, radius: float) -> None:
    """Draws each pair of joined nodes once, and its distance in cm where the discs of nodes leave room."""
    drawn: set[tuple[int, int]] = set()
    for arc in drawing.arcs:
        pair = (min(arc.start, arc.end), max(arc.start, arc.end))
        if pair in drawn or not {arc.start, arc.end} <= drawing.nodes.keys():
            continue
        drawn.add(pair)
        start, end = drawing.nodes[arc.start], drawing.nodes[arc.end]
        axes.plot([start.x, end.x], [start.y, end.y], color=ARC, linewidth=2.4, zorder=2)
        if start.distance_to(end) < 5 * radius:
            continue
        angle = math.degrees(math.atan2(end.y - start.y, end.x - start.x))
        axes.text(
            (start.x + end.x) / 2,
            (start.y + end.y) / 2,
            f"{100 * arc.distance:.0f} cm",
            rotation=(angle + 90) % 180 - 90,
            fontsize=6.5,
            color=ARC,
            ha="center",
            va="center",
            zorder=5,
            bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8},
        )


def draw_nodes(axes: Axes, drawing: Drawing, radius: float) -> None:
    """Draws each node as a numbered disc with a tick towards its entry heading."""
    for node, pose in drawing.nodes.items():
        tip = pose.compose(1.9 * radius, 0.0)
        axes.plot([pose.x, tip.x], [pose.y, tip.y], color=NODE, linewidth=2.0, zorder=6)
        axes.add_patch(Circle((pose.x, pose.y), radius, fc=NODE, ec="white", lw=0.8, zorder=7))
        axes.text(
            pose.x,
            pose.y,
            drawing.labels.get(node, str(node)),
            color="white",
            fontsize=7 if len(drawing.nodes) <= 12 else 5,
            fontweight="bold",
            ha="center",
            va="center_baseline",
            zorder=8,
        )


def legend(axes: Axes, drawing: Drawing) -> None:
    """Explains what is drawn, below the picture."""
    keys = [axes.plot([], [], "o", color=NODE, markersize=7, label="node, with entry heading")[0]]
    if drawing.arcs:
        keys.append(axes.plot([], [], color=ARC, linewidth=2.4, label="arc, as measured")[0])
    if drawing.lattices:
        keys.append(axes.plot([], [], ".-", color=LATTICE, linewidth=0.8, label="metric SOM")[0])
    if len(drawing.track):
        keys.append(axes.plot([], [], color=PATH, linewidth=0.9, label="path truly driven")[0])
    if drawing.shapes:
        keys.append(axes.plot([], [], "s", color=WALL, markersize=7, label="wall")[0])
    axes.legend(
        handles=keys, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=3, frameon=False, fontsize=8
    )


def extent(drawing: Drawing) -> tuple[float, float, float, float]:
    """Least and largest x and y (m) of what is drawn, with a margin."""
    places = [np.array([[pose.x, pose.y] for pose in drawing.nodes.values()]).reshape(-1, 2), drawing.track]
    places += [np.array(outline(shape)) for shape in drawing.shapes]
    places += [placed(lattice.weights, drawing.nodes[node]) for node, lattice in drawing.lattices.items()]
    points = np.concatenate([place[np.isfinite(place).all(axis=1)] for place in places])
    if not len(points):
        points = np.zeros((1, 2))
    least, most = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * max(float((most - least).max()), 0.2)
    return least[0] - margin, most[0] + margin, least[1] - margin, most[1] + margin


def compose_figure(drawing: Drawing) -> Figure:
    """The whole picture as a matplotlib figure that no window and no global state knows."""
    left, right, bottom, top = extent(drawing)
    width = 7.2
    height = min(14.0, max(3.5, width * (top - bottom) / (right - left))) + 1.0
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.add_subplot()
    for shape in drawing.shapes:
        axes.add_patch(PolygonPatch(outline(shape), closed=True, fc=WALL, ec=WALL, lw=0.5, zorder=1))
    if len(drawing.track):
        axes.plot(drawing.track[:, 0], drawing.track[:, 1], color=PATH, lw=0.7, zorder=2.5)
    for node, lattice in drawing.lattices.items():
        draw_lattice(axes, lattice, drawing.nodes[node])
    radius = (0.016 if len(drawing.nodes) <= 12 else 0.011) * (right - left)
    draw_arcs(axes, drawing, radius)
    draw_nodes(axes, drawing, radius)
    legend(axes, drawing)
    axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.set_title(drawing.title, fontsize=10)
    axes.tick_params(labelsize=8)
    return figure


def save_drawing(drawing: Drawing, path: Path) -> None:
    """Writes the picture; the suffix of `path` says whether PNG, SVG or PDF."""
    kind = path.suffix.lower().lstrip(".")
    with mpl.rc_context({"svg.hashsalt": "tolman", "font.family": "DejaVu Sans", "path.simplify": True}):
        compose_figure(drawing).savefig(path, format=kind, dpi=DOTS_PER_INCH, metadata=NO_DATES[kind])
