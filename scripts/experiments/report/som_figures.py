"""Figures of local maps: what was sampled, and what self-organizing maps make of it (figures 4.7 to 4.11)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from ....maps.som.lattice import lattice_of
from ....world.robot import Pose
from ...drawing.plot import WALL
from ...session.truth import TrueRun, read_map_truth
from ..campaign.campaign import Job, Result
from ..campaign.jobs import map_path
from ..campaign.kinds import LOCAL
from ..campaign.plan import Outcome, Plan
from ..worlds.named import experiment_world

Points = NDArray[np.float64]
_HALF = 0.15
"""Half the side (m) of what is drawn around a node."""
_SHOWN = 3
PATH, UNIT = "#7b8ba3", "#bf616a"


def examples(plan: Plan, outcome: Outcome) -> list[tuple[Job, dict[str, Any]]]:
    """The local maps to draw, with the mapping they are of: of the first environment that has some."""
    for world in plan.environments:
        for job, result in outcome.runs(LOCAL, world, "default"):
            if found := _most_open(result):
                return [(job, example) for example in found]
    return []


def _most_open(result: Result) -> list[dict[str, Any]]:
    """The examples with the most samples, in the order of their nodes."""
    found = sorted(result.get("examples", []), key=lambda example: -len(example["positions"]))
    return sorted(found[:_SHOWN], key=lambda example: int(example["node"]))


def metric_figure(shown: list[tuple[Job, dict[str, Any]]], work: Path) -> Figure:
    """Samples, and metric SOMs of three sizes and both published configurations; a row a local map."""
    names = sorted(shown[0][1]["metric"], key=lambda name: (name.rpartition(", ")[0], len(name), name))
    figure = Figure(figsize=(2.2 * (1 + len(names)), 2.35 * len(shown)), layout="constrained")
    grid = figure.subplots(len(shown), 1 + len(names), squeeze=False)
    for row, (job, example) in zip(grid, shown, strict=True):
        node = int(example["node"])
        for axes, title in zip(row, [f"node {node}: samples", *names], strict=True):
            _local_frame(axes, title, job, node, work)
        positions, views = _points(example["positions"]), _points(example["views"])
        row[0].plot(positions[:, 0], positions[:, 1], "o", ms=2.5, mfc="none", mec=PATH, mew=0.6)
        row[0].plot(views[:, 0], views[:, 1], "x", ms=4, color=UNIT, mew=0.9)
        for axes, name in zip(row[1:], names, strict=True):
            _draw_som(axes, _points(example["metric"][name]))
    return figure


def perceptual_figure(shown: list[tuple[Job, dict[str, Any]]], work: Path) -> Figure:
    """Where views were taken, numbered, and the units of the perceptual SOMs that they fall on."""
    names = list(shown[0][1]["perceptual"])
    figure = Figure(figsize=(2.9 * (1 + len(names)), 2.9 * len(shown)), layout="constrained")
    grid = figure.subplots(len(shown), 1 + len(names), squeeze=False)
    for row, (job, example) in zip(grid, shown, strict=True):
        node, views = int(example["node"]), _points(example["views"])
        _local_frame(row[0], f"node {node}: views", job, node, work)
        for number, (x, y) in enumerate(views, 1):
            row[0].text(x, y, str(number), fontsize=7, ha="center", va="center", color=UNIT)
        for axes, name in zip(row[1:], names, strict=True):
            _draw_units(axes, name, example["perceptual"][name])
    return figure


def truth_of(job: Job, work: Path) -> TrueRun | None:
    """What truly happened in a mapping, if the work folder has its map."""
    path = map_path(work, job)
    return read_map_truth(path) if path.exists() else None


def _points(values: Any) -> Points:
    return np.array(values, dtype=float).reshape(-1, 2)


def _local_frame(axes: Axes, title: str, job: Job, node: int, work: Path) -> None:
    """Prepares axes in a node's local frame, its walls drawn where they truly are."""
    axes.set_aspect("equal")
    axes.set(xlim=(-_HALF, _HALF), ylim=(-_HALF, _HALF), xticks=[], yticks=[])
    axes.set_title(title, fontsize=8)
    truth = truth_of(job, work)
    if truth is None or node not in truth.nodes:
        return
    for shape in experiment_world(str(job.settings["world"]), work).shapes:
        axes.add_patch(Polygon(_seen_from(truth.nodes[node], shape.outline()), closed=True, fc=WALL, ec=WALL))


def _seen_from(pose: Pose, points: Any) -> Points:
    away = _points(points) - (pose.x, pose.y)
    cosine, sine = np.cos(pose.heading), np.sin(pose.heading)
    seen: Points = away @ np.array([[cosine, -sine], [sine, cosine]])
    return seen


def _draw_som(axes: Axes, weights: Points) -> None:
    """One metric SOM: all lattice edges, and the units."""
    size = round(len(weights) ** 0.5)
    lines = [(weights[a], weights[b]) for a, b in lattice_of(size, size).edges]
    axes.add_collection(LineCollection(lines, colors=UNIT, linewidths=0.6))
    axes.plot(weights[:, 0], weights[:, 1], "o", ms=2.2, color=UNIT)


def _draw_units(axes: Axes, title: str, winners: list[int]) -> None:
    """A hexagonal lattice, each unit with the numbers of the views that fall on it."""
    lattice = lattice_of(5, 5)
    places = lattice.positions
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{title}: {len(set(winners))} units used", fontsize=8)
    axes.scatter(
        places[:, 0], places[:, 1], s=330, c="white", edgecolors="#9aa5b1", marker="h", linewidths=0.8
    )
    for unit in sorted(set(winners)):
        numbers = ",".join(str(k) for k, winner in enumerate(winners, 1) if winner == unit)
        axes.text(
            places[unit, 0],
            places[unit, 1],
            numbers,
            fontsize=6 if len(numbers) < 6 else 4.5,
            ha="center",
            va="center",
        )
    axes.margins(0.15)
