"""Draws a map: walls, the path truly driven, nodes, arcs and the metric SOMs, to PNG, SVG or PDF.

The same content gives the same bytes: no dates, no random ids. Only this module draws; it needs no display.
"""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch
from matplotlib.patches import Polygon as PolygonPatch
from numpy.typing import NDArray

from ...files.writing import atomic_file
from ...world.robot import EPUCK, Pose
from .style import ArcLine, Drawing, Lattice, extent, placed

WALL, PATH, ARC, FORAY, BLOCKED = "#3b4252", "#e0a080", "#2e7d32", "#7b4ea3", "#d32f2f"
LATTICE, FREE = "#44719f", "#e3edf7"
NODE = "#bf616a"
CORNERS = {"concave": NODE, "convex": "#c77d14", "none": "#747a86"}
"""Colors of nodes by the corner they stand at; `none` is a place without one, such as on a round wall."""

DOTS_PER_INCH = 130
NO_DATES = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None, "Producer": None}}


def draw_lattice(axes: Axes, lattice: Lattice, pose: Pose) -> None:
    """Draws one metric SOM: its free space, kept edges, units as dots, hollow where no sample fell."""
    points = placed(lattice.weights, pose)
    _draw_free_space(axes, lattice, points)
    for blocked, color, width in ((False, LATTICE, 0.7), (True, BLOCKED, 1.4)):
        lines = [(points[a], points[b]) for a, b in lattice.edges if ((a, b) in lattice.blocked) == blocked]
        axes.add_collection(LineCollection(lines, colors=color, linewidths=width, zorder=3))
    for hit, color in ((True, LATTICE), (False, "white")):
        chosen = points[lattice.hit == hit]
        axes.scatter(chosen[:, 0], chosen[:, 1], s=5, c=color, edgecolors=LATTICE, linewidths=0.4, zorder=4)


def _draw_free_space(axes: Axes, lattice: Lattice, points: NDArray[np.float64]) -> None:
    """Shades what the robot's body covers on the free edges."""
    radius = EPUCK.body_radius
    patches: list[Patch] = [Circle((x, y), radius) for x, y in points[lattice.hit].tolist()]
    for edge in lattice.edges:
        start, end = points[edge[0]], points[edge[1]]
        length = float(np.hypot(*(end - start)))
        if edge not in lattice.blocked and length > 0.0:
            aside = radius / length * np.array([start[1] - end[1], end[0] - start[0]])
            patches.append(
                PolygonPatch([start + aside, end + aside, end - aside, start - aside], closed=True)
            )
    axes.add_collection(PatchCollection(patches, facecolors=FREE, edgecolors="none", zorder=0.5))


def draw_arcs(axes: Axes, drawing: Drawing, radius: float) -> None:
    """Draws each pair of joined nodes once a way, and its distance in cm where the discs leave room.

    Ways along walls are lines; forays are dashed arrows, bent where a wall joins the two nodes as well.
    """
    drawn: set[tuple[int, int, bool]] = set()
    for arc in sorted(drawing.arcs, key=lambda arc: arc.foray):
        first, last = min(arc.start, arc.end), max(arc.start, arc.end)
        if (first, last, arc.foray) in drawn or not {first, last} <= drawing.nodes.keys():
            continue
        drawn.add((first, last, arc.foray))
        beside = arc.foray and (first, last, False) in drawn
        draw_arc(axes, drawing, arc, radius, 0.25 if beside else 0.0)


def draw_arc(axes: Axes, drawing: Drawing, arc: ArcLine, radius: float, bend: float) -> None:
    """Draws one arc and, if there is room, its distance. bend: of a foray, as a share of its length."""
    start, end = drawing.nodes[arc.start], drawing.nodes[arc.end]
    color = BLOCKED if arc.blocked else FORAY if arc.foray else ARC
    if arc.start == arc.end:  # once round an obstacle that has no other node
        axes.add_patch(Circle((start.x, start.y), 1.5 * radius, fill=False, ec=color, lw=2.4, zorder=2))
        return
    if arc.foray:
        style = f"arc3,rad={bend}"
        axes.add_patch(
            FancyArrowPatch(
                (start.x, start.y),
                (end.x, end.y),
                connectionstyle=style,
                arrowstyle="-|>",
                mutation_scale=9,
                shrinkA=7,
                shrinkB=7,
                color=color,
                linewidth=1.4,
                linestyle=(0, (4, 2)),
                zorder=2.6,
            )
        )
    else:
        line = ":" if arc.blocked else "-"
        axes.plot([start.x, end.x], [start.y, end.y], color=color, linewidth=2.4, linestyle=line, zorder=2)
    if start.distance_to(end) < 5 * radius:
        return
    angle = math.degrees(math.atan2(end.y - start.y, end.x - start.x))
    # matplotlib bends by half of `rad` times the length, to the right of the way.
    aside = 0.5 * bend * np.array([end.y - start.y, start.x - end.x])
    axes.text(
        (start.x + end.x) / 2 + aside[0],
        (start.y + end.y) / 2 + aside[1],
        f"{100 * arc.distance:.0f} cm",
        rotation=(angle + 89.0) % 180.0 - 89.0,  # read from below or from the right
        fontsize=6.5,
        color=color,
        ha="center",
        va="center",
        zorder=5,
        bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85},
    )


def draw_nodes(axes: Axes, drawing: Drawing, radius: float) -> None:
    """Draws each node as a numbered disc, colored by its corner, with a tick towards its entry heading."""
    for node, pose in drawing.nodes.items():
        color = _node_color(drawing, node)
        tip = pose.compose(1.9 * radius, 0.0)
        axes.plot([pose.x, tip.x], [pose.y, tip.y], color=color, linewidth=2.0, zorder=6)
        axes.add_patch(Circle((pose.x, pose.y), radius, fc=color, ec="white", lw=0.8, zorder=7))
        axes.text(
            pose.x,
            pose.y,
            str(node),
            color="white",
            fontsize=7 if len(drawing.nodes) <= 12 else 5,
            fontweight="bold",
            ha="center",
            va="center_baseline",
            zorder=8,
        )


def _node_color(drawing: Drawing, node: int) -> str:
    return CORNERS.get(drawing.corners.get(node, "concave"), CORNERS["none"])


def legend(axes: Axes, drawing: Drawing) -> None:
    """Explains what is drawn, below the picture; nothing that is not."""
    found = {drawing.corners.get(node, "concave") for node in drawing.nodes}
    names = {"concave": "node at a concave corner", "convex": "node at a convex corner", "none": "other node"}
    keys = [
        axes.plot([], [], "o", color=CORNERS[corner], markersize=7, label=names[corner])[0]
        for corner in CORNERS
        if corner in found
    ]
    ways = (
        (any(not arc.foray for arc in drawing.arcs), ARC, "-", 2.4, "arc along a wall, as measured"),
        (any(arc.foray for arc in drawing.arcs), FORAY, "--", 1.4, "foray across open space"),
        (any(arc.blocked for arc in drawing.arcs), BLOCKED, ":", 2.4, "blocked"),
        (len(drawing.track) > 0, PATH, "-", 0.9, "path truly driven"),
    )
    for there, color, line, width, name in ways:
        if there:
            keys.append(axes.plot([], [], line, color=color, linewidth=width, label=name)[0])
    if drawing.lattices:
        keys.append(axes.plot([], [], ".-", color=LATTICE, linewidth=0.8, label="metric SOM")[0])
        keys.append(axes.plot([], [], "s", color=FREE, markersize=7, label="free space it knows")[0])
    if drawing.shapes:
        keys.append(axes.plot([], [], "s", color=WALL, markersize=7, label="wall")[0])
    axes.legend(
        handles=keys, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=3, frameon=False, fontsize=8
    )


def compose_figure(drawing: Drawing) -> Figure:
    """The whole picture as a matplotlib figure that no window and no global state knows."""
    left, right, bottom, top = extent(drawing)
    width = 7.2
    height = min(14.0, max(3.5, width * (top - bottom) / (right - left))) + 1.3
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.add_subplot()
    for shape in drawing.shapes:
        axes.add_patch(PolygonPatch(shape.outline(), closed=True, fc=WALL, ec=WALL, lw=0.5, zorder=1))
    if len(drawing.track):
        axes.plot(drawing.track[:, 0], drawing.track[:, 1], color=PATH, lw=0.8, zorder=1.5)
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
        figure = compose_figure(drawing)
        with atomic_file(path, replace=True) as file:
            figure.savefig(file, format=kind, dpi=DOTS_PER_INCH, metadata=NO_DATES[kind])
