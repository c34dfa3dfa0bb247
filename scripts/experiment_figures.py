"""The figures of an experiment, in kind those of chapter 4: paths, estimates, trained maps, corrections."""

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

from ..maps.hybrid_map import HybridMap
from ..world.arenas import find_world
from ..world.geometry import outline
from ..world.robot import Pose
from .campaign import Job, Result
from .experiment_mapping import map_path
from .experiment_plan import CORRECTED, GLOBAL, LOCAL, Outcome, Plan, average_maps
from .experiment_running import SIDES
from .map_drawing import lattice_of
from .plot import DOTS_PER_INCH, NO_DATES, NODE, WALL, draw_lattice
from .truth import read_map_truth

SIDE_COLORS = {"right": "#d08770", "left": "#5e81ac"}
_EXAMPLES = 3


def draw_figures(plan: Plan, outcome: Outcome, work: Path, folder: Path, base: Path) -> list[tuple[str, str]]:
    """Draws what the runs allow; returns (title, path from `base`) of each picture."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    for name, title, figure in _figures(plan, outcome, work):
        path = folder / f"{name}.png"
        with mpl.rc_context({"font.family": "DejaVu Sans"}):
            figure.savefig(path, format="png", dpi=DOTS_PER_INCH, metadata=NO_DATES["png"])
        pictures.append((title, Path(os.path.relpath(path, base)).as_posix()))
    return pictures


def _figures(plan: Plan, outcome: Outcome, work: Path) -> Iterator[tuple[str, str, Figure]]:
    kind = GLOBAL if GLOBAL in plan.kinds else LOCAL
    yield (
        "paths",
        "Paths truly driven, right side and left side (figures 4.3, 4.4, 4.17)",
        _paths(plan, outcome, work, kind),
    )
    yield (
        "estimates",
        "Nodes where path integration puts them (crosses) and where they are (figure 4.5)",
        _estimates(plan, outcome, work, kind),
    )
    if LOCAL in plan.kinds:
        yield "soms", "Trained metric SOMs and tied views (figures 4.10, 4.11)", _soms(plan, outcome, work)
    if CORRECTED in plan.kinds:
        yield (
            "corrections",
            "Where the robot was on arrival (blue), where it then held itself to be (red; figure 4.13)",
            _corrections(plan, outcome),
        )


def _grid(plan: Plan, columns: int) -> tuple[Figure, NDArray[np.object_]]:
    """One row of axes a profile."""
    figure = Figure(figsize=(3.4 * columns, 3.5 * len(plan.profiles)), layout="constrained")
    axes = figure.subplots(len(plan.profiles), columns, squeeze=False)
    return figure, axes


def _prepare(axes: Axes, title: str) -> None:
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=9)
    axes.tick_params(labelsize=7)


def _walls(axes: Axes, world: str) -> None:
    for shape in find_world(world).shapes:
        axes.add_patch(Polygon(outline(shape), closed=True, fc=WALL, ec=WALL, lw=0.5))


def _runs(outcome: Outcome, key: tuple[str, str, str]) -> Iterator[tuple[Job, Result]]:
    yield from zip(outcome.jobs.get(key, []), outcome.results.get(key, []), strict=True)


def _paths(plan: Plan, outcome: Outcome, work: Path, kind: str) -> Figure:
    figure, grid = _grid(plan, len(plan.environments))
    for row, profile in zip(grid, plan.profiles, strict=True):
        for axes, world in zip(row, plan.environments, strict=True):
            _prepare(axes, f"{world}, profile {profile}")
            _walls(axes, world)
            for side in SIDES:
                runs = (job for job, _ in _runs(outcome, (kind, world, profile)))
                job = next((job for job in runs if job.settings["side"] == side), None)
                truth = read_map_truth(map_path(work, job)) if job and map_path(work, job).exists() else None
                if truth is None:
                    continue
                axes.plot(truth.track[:, 0], truth.track[:, 1], color=SIDE_COLORS[side], lw=0.7)
                places = np.array([[pose.x, pose.y] for pose in truth.nodes.values()])
                axes.plot(places[:, 0], places[:, 1], "o", color=SIDE_COLORS[side], ms=3)
            axes.autoscale_view()
    return figure


def _estimates(plan: Plan, outcome: Outcome, work: Path, kind: str) -> Figure:
    figure, grid = _grid(plan, len(plan.environments))
    for row, profile in zip(grid, plan.profiles, strict=True):
        for axes, world in zip(row, plan.environments, strict=True):
            _prepare(axes, f"{world}, profile {profile}")
            _walls(axes, world)
            for index, (job, result) in enumerate(_runs(outcome, (kind, world, profile))):
                path = map_path(work, job)
                truth = read_map_truth(path) if index == 0 and path.exists() else None
                places = np.array(list(result["estimates"].values())).reshape(-1, 2)
                axes.plot(places[:, 0], places[:, 1], "x-", ms=3, lw=0.4, color=f"C{index % 10}", alpha=0.7)
                if truth is not None:
                    true = np.array([[pose.x, pose.y] for pose in truth.nodes.values()])
                    axes.plot(true[:, 0], true[:, 1], "o", color=NODE, ms=3, zorder=5)
                if index + 1 == _EXAMPLES:
                    break
            axes.autoscale_view()
    return figure


def _soms(plan: Plan, outcome: Outcome, work: Path) -> Figure:
    figure, grid = _grid(plan, 2 * _EXAMPLES)
    for row, profile in zip(grid, plan.profiles, strict=True):
        maps = average_maps(outcome, plan.environments[0], profile)
        path = map_path(work, next(iter(maps.values()))) if maps else None
        hybrid = HybridMap.load(path) if path is not None and path.exists() else None
        nodes = [] if hybrid is None else [n for n in hybrid.nodes() if hybrid.local_map(n) is not None]
        for index in range(_EXAMPLES):
            space, views = row[2 * index], row[2 * index + 1]
            for axes in (space, views):
                axes.set_axis_off()
            if hybrid is None or index >= len(nodes):
                continue
            node = nodes[index * len(nodes) // _EXAMPLES]
            local_map = hybrid.local_map(node)
            assert local_map is not None
            _prepare(space, f"{profile}, node {node}: space")
            draw_lattice(space, lattice_of(local_map), Pose())
            space.autoscale_view()
            _prepare(views, "views tied to units")
            tied = local_map.view_positions
            if tied is not None and local_map.perceptual is not None:
                known = np.isfinite(tied).all(axis=1)
                views.scatter(tied[known, 0], tied[known, 1], s=12, c=np.flatnonzero(known), cmap="viridis")
                views.set(xlim=(-0.15, 0.15), ylim=(-0.15, 0.15))
    return figure


def _corrections(plan: Plan, outcome: Outcome) -> Figure:
    figure, grid = _grid(plan, len(plan.environments))
    for row, profile in zip(grid, plan.profiles, strict=True):
        for axes, world in zip(row, plan.environments, strict=True):
            _prepare(axes, f"{world}, profile {profile}")
            for result in outcome.of(CORRECTED, world, profile):
                points = np.array(result["corrections"], dtype=float).reshape(-1, 5)
                axes.plot(100 * points[:, 1], 100 * points[:, 2], "x", color="#1f77b4", ms=3, alpha=0.6)
                axes.plot(100 * points[:, 3], 100 * points[:, 4], "+", color="#d62728", ms=3, alpha=0.4)
            axes.set(xlim=(-15, 15), ylim=(-15, 15), xlabel="x (cm), entry heading", ylabel="y (cm)")
            axes.xaxis.label.set_size(7)
            axes.yaxis.label.set_size(7)
    return figure
