"""The figures of an experiment, in kind those of chapter 4: paths, estimates, SOMs, errors, corrections."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from ....files.writing import atomic_file
from ....world.arenas.catalog import find_world
from ...drawing.plot import DOTS_PER_INCH, NO_DATES, NODE, WALL
from ..campaign.jobs import SIDES
from ..campaign.kinds import CORRECTED, GLOBAL, LOCAL, UNCORRECTED
from ..campaign.plan import Outcome, Plan
from .som_figures import examples, metric_figure, perceptual_figure, truth_of

SIDE_COLORS = {"right": "#d08770", "left": "#5e81ac"}
_RUNS = 3
"""Runs whose estimates are drawn."""


def draw_figures(plan: Plan, outcome: Outcome, work: Path, folder: Path, base: Path) -> list[tuple[str, str]]:
    """Draws what the runs allow; returns (title, path from `base`) of each picture."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    for name, title, figure in _figures(plan, outcome, work):
        path = folder / f"{name}.png"
        with mpl.rc_context({"font.family": "DejaVu Sans"}), atomic_file(path, replace=True) as file:
            figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata=NO_DATES["png"])
        pictures.append((title, Path(os.path.relpath(path, base)).as_posix()))
    return pictures


def _figures(plan: Plan, outcome: Outcome, work: Path) -> Iterator[tuple[str, str, Figure]]:
    kind = GLOBAL if GLOBAL in plan.kinds else LOCAL
    yield (
        "paths",
        "Paths truly driven while mapping, and nodes: the first run of each side (figures 4.3, 4.4, 4.17)",
        _paths(plan, outcome, work, kind),
    )
    yield (
        "estimates",
        "Nodes where path integration puts them in the first runs, a line a run, and where they truly are in "
        "the first (dots; figure 4.5)",
        _estimates(plan, outcome, work, kind),
    )
    shown = examples(plan, outcome) if LOCAL in plan.kinds else []
    if shown:
        yield (
            "metric-soms",
            "Samples of local maps (circles: places, crosses: views) and metric SOMs trained on them, in the "
            "local frame, walls gray (figures 4.7, 4.9, 4.10)",
            metric_figure(shown, work),
        )
        yield (
            "perceptual-soms",
            "Where views were taken, and the units of the perceptual SOMs that they fall on (figure 4.11)",
            perceptual_figure(shown, work),
        )
    if UNCORRECTED in plan.kinds:
        yield (
            "traversals",
            "Position error at the end of each of five uncorrected traversals, a line a run (as figure 4.12)",
            _traversals(plan, outcome),
        )
    if CORRECTED in plan.kinds:
        yield (
            "corrections",
            "Where the robot truly was on arrival at nodes, in their local frames (blue), and where it then "
            "held itself to be (red; profile `default` comes to the corner instead: the middle). Scales "
            "differ (figures 4.13 to 4.15)",
            _corrections(plan, outcome),
        )


def _grid(plan: Plan, height: float = 3.5) -> tuple[Figure, NDArray[np.object_]]:
    """One row of axes a profile, a column an environment."""
    columns = len(plan.environments)
    figure = Figure(figsize=(3.4 * columns, height * len(plan.profiles)), layout="constrained")
    return figure, figure.subplots(len(plan.profiles), columns, squeeze=False)


def _cells(plan: Plan, grid: NDArray[np.object_]) -> Iterator[tuple[Axes, str, str]]:
    """Each of the axes with its profile and environment, titled."""
    for row, profile in zip(grid, plan.profiles, strict=True):
        for axes, world in zip(row, plan.environments, strict=True):
            axes.set_title(f"{world}, profile {profile}", fontsize=9)
            axes.tick_params(labelsize=7)
            axes.xaxis.label.set_size(7)
            axes.yaxis.label.set_size(7)
            yield axes, profile, world


def _room(axes: Axes, world: str) -> None:
    """The room's walls, and its inside as limits."""
    axes.set_aspect("equal")
    corners: list[tuple[float, float]] = []
    for shape in find_world(world).shapes:
        points = shape.outline()
        corners += points
        axes.add_patch(Polygon(points, closed=True, fc=WALL, ec=WALL, lw=0.5))
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xticks=[], yticks=[])


def _paths(plan: Plan, outcome: Outcome, work: Path, kind: str) -> Figure:
    figure, grid = _grid(plan)
    for axes, profile, world in _cells(plan, grid):
        _room(axes, world)
        for side in SIDES:
            runs = (job for job, _ in outcome.runs(kind, world, profile))
            job = next((job for job in runs if job.settings["side"] == side), None)
            truth = truth_of(job, work) if job is not None else None
            if truth is None:
                continue
            axes.plot(truth.track[:, 0], truth.track[:, 1], color=SIDE_COLORS[side], lw=0.8, label=side)
            places = np.array([[pose.x, pose.y] for pose in truth.nodes.values()])
            marker = "o" if side == "right" else "s"
            axes.plot(places[:, 0], places[:, 1], marker, color=SIDE_COLORS[side], ms=3.5, mfc="none")
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    return figure


def _estimates(plan: Plan, outcome: Outcome, work: Path, kind: str) -> Figure:
    figure, grid = _grid(plan)
    for axes, profile, world in _cells(plan, grid):
        _room(axes, world)
        shown = []
        for index, (job, result) in enumerate(outcome.runs(kind, world, profile)[:_RUNS]):
            truth = truth_of(job, work) if index == 0 else None
            places = np.array(list(result["estimates"].values())).reshape(-1, 2)
            axes.plot(places[:, 0], places[:, 1], "x-", ms=4, lw=0.6, color=f"C{index}", zorder=4)
            shown.append(places)
            if truth is not None:
                true = np.array([[pose.x, pose.y] for pose in truth.nodes.values()])
                axes.plot(true[:, 0], true[:, 1], "o", color=NODE, ms=3.5, zorder=5)
        _widen(axes, np.concatenate(shown) if shown else np.empty((0, 2)))
    return figure


def _widen(axes: Axes, points: NDArray[np.float64]) -> None:
    """Limits that also hold these points."""
    if len(points):
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        (low_x, low_y), (high_x, high_y) = points.min(axis=0) - 0.03, points.max(axis=0) + 0.03
        axes.set(xlim=(min(x0, low_x), max(x1, high_x)), ylim=(min(y0, low_y), max(y1, high_y)))


def _traversals(plan: Plan, outcome: Outcome) -> Figure:
    figure, grid = _grid(plan, 2.6)
    for axes, profile, world in _cells(plan, grid):
        for job, result in outcome.runs(UNCORRECTED, world, profile):
            ends = 100.0 * np.array(result["ends"], dtype=float)
            color = SIDE_COLORS[str(job.settings["map side"])]
            axes.plot(range(1, len(ends) + 1), ends, ".-", color=color, lw=0.7, ms=4, alpha=0.8)
        axes.set(xlabel="traversal", ylabel="position error (cm)", xticks=range(1, 6))
        axes.set_ylim(bottom=0.0)
    return figure


def _corrections(plan: Plan, outcome: Outcome) -> Figure:
    figure, grid = _grid(plan)
    for axes, profile, world in _cells(plan, grid):
        axes.set_aspect("equal")
        reach = 15.0 if profile == "thesis" else 1.0
        for result in outcome.of(CORRECTED, world, profile):
            points = 100.0 * np.array(result["corrections"], dtype=float).reshape(-1, 5)
            axes.plot(points[:, 1], points[:, 2], "x", color="#1f77b4", ms=3, alpha=0.5)
            axes.plot(points[:, 3], points[:, 4], "+", color="#d62728", ms=4, alpha=0.6)
        axes.axhline(0.0, color="#cccccc", lw=0.5, zorder=0)
        axes.axvline(0.0, color="#cccccc", lw=0.5, zorder=0)
        axes.set(
            xlim=(-reach, reach),
            ylim=(-reach, reach),
            xlabel="along the entry heading (cm)",
            ylabel="to its left (cm)",
        )
    return figure
