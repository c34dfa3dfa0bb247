"""One mapping run of an experiment: from plain settings to plain figures, its map kept in the work folder."""

from __future__ import annotations

import os
from collections.abc import Mapping as Settings
from dataclasses import replace
from pathlib import Path
from typing import Any

from ....agent.listener import Outcome
from ....agent.mapping.published import ThesisMapper
from ....world.errors import SimulationError
from ...session.map_files import MapWriter
from ...session.mapping import Mapping
from ...session.profiles import find_profile
from ...session.requests import MapRequest
from ...session.simulation import Simulation, settings_of
from ..campaign.campaign import Job
from ..campaign.jobs import map_path
from ..worlds.named import experiment_world
from .probes import AT_NODE, ExplorationProbe, LapProbe
from .training import TrainingMapping

LONGEST = 60_000.0
"""Simulated seconds after which a mapping of an experiment is given up."""


def run_mapping(settings: Settings[str, Any], folder: Path) -> dict[str, Any]:
    """Runs the mapping of a job; lengths in m, angles in rad.

    The map appears under its name when the run is over: whoever finds it there finds it whole.
    """
    path = map_path(folder, Job(settings))
    path.parent.mkdir(parents=True, exist_ok=True)
    for left_over in path.parent.glob(f"{path.stem}-*"):  # of a run that was killed
        left_over.unlink()
    growing = path.with_name(f"{path.stem}-{os.getpid()}.tolman")
    request = MapRequest(
        world=str(settings["world"]),
        output=growing,
        side=str(settings["side"]),
        seed=int(settings["seed"]),
        profile=str(settings["profile"]),
        global_only=not settings["local_maps"],
        noise=str(settings["noise"]),
        noise_scale=float(settings["noise_scale"]),
        max_time=LONGEST,
        islands=bool(settings.get("islands", False)),
        force=True,
    )
    # A lap for the thesis's profile: how its thresholds would have closed the loop follows from the ratios.
    profile = replace(find_profile(request.profile), closing=None)
    world = experiment_world(request.world, folder)
    kind = TrainingMapping if settings["training"] else Mapping
    with (
        Simulation(world, settings_of(request), start=request.side, profile=profile) as simulation,
        MapWriter.open(growing, request, simulation.map_meta(request)) as writer,
    ):
        result = _figures(kind(simulation, request, writer=writer))
    os.replace(growing, path)
    return result


def _figures(run: Mapping) -> dict[str, Any]:
    """Maps, and returns what came of it."""
    lap, exploration = LapProbe(run), ExplorationProbe(run)
    try:
        report = run.drive()
    except SimulationError as error:  # counts as a run that did not get round; the others go on
        run.outcome = Outcome(False, reason=str(error))
        report = run.report()
    return report.to_json() | {
        "finished": report.reason in ("loop closed", "lap"),
        "path_integration_error_m": lap.error,
        "explored": [list(pair) for pair in exploration.after],
        "docked": [list(pair) for pair in exploration.docked],
        "estimates": {str(node): list(place) for node, place in lap.estimates.items()},
        "trained": getattr(run, "trained", []),
        "examples": getattr(run, "examples", []),
        **_first_views(run),
    }


def _first_views(run: Mapping) -> dict[str, Any]:
    """How far nodes' first views were from node 0's perceptual SOM (in D_a), in a run of profile `thesis`.

    views: that, and how far each node is from node 0 (m). closing: what eq. 3.33 would have done at the three
    thresholds of table 4.17: right, wrong or missed.
    """
    mapper, truth = run.mapper, run.observer.nodes
    if not isinstance(mapper, ThesisMapper):
        return {"closing": {}, "views": []}
    views = [[ratio, truth[node].distance_to(truth[0])] for node, ratio in sorted(mapper.ratios.items())]
    closing = {}
    for name, threshold in (("T1", 0.5), ("T2", 1.0), ("T3", 2.0)):
        taken = next((distance for ratio, distance in views if ratio < threshold), None)
        closing[name] = "missed" if taken is None else "right" if taken <= AT_NODE else "wrong"
    return {"closing": closing if views else {}, "views": views}
