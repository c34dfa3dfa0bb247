"""One mapping run of an experiment: from plain settings to plain figures, its map kept in the work folder."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ....agent.mapping.published import ThesisMapper
from ....world.errors import SimulationError
from ....world.robot import Pose
from ...session.assembly import make_world
from ...session.mapping_run import MappingRun, open_map_file
from ...session.profiles import find_profile
from ...session.requests import MapRequest
from ..campaign.campaign import Job
from ..campaign.jobs import map_path
from ..worlds.named import experiment_world
from .probes import AT_NODE, ExplorationProbe, LapProbe
from .training import TrainingRun

LONGEST = 60_000.0
"""Simulated seconds after which a mapping of an experiment is given up."""


def run_mapping(settings: Mapping[str, Any], folder: Path) -> dict[str, Any]:
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
    spec = experiment_world(request.world, folder)
    world = make_world(request, spec, {}, request.side)
    with contextlib.closing(world), open_map_file(request, world) as file:
        kind = TrainingRun if settings["training"] else MappingRun
        run = kind(request, world, file, {}, profile, lambda progress: None)
        lap, exploration = LapProbe(run), ExplorationProbe(run)
        try:
            run.drive()
        except SimulationError as error:  # counts as a run that did not get round; the others go on
            run.reason, run.wall_time = str(error), 0.0
        result = run.report().to_json()
        result["finished"] = run.reason in ("loop closed", "lap")
        result["path_integration_error_m"] = lap.error
        result["explored"] = [list(pair) for pair in exploration.after]
        result["docked"] = [list(pair) for pair in exploration.docked]
        result["estimates"] = {str(node): list(place) for node, place in lap.estimates.items()}
        result["trained"] = getattr(run, "trained", [])
        result["examples"] = getattr(run, "examples", [])
        result["closing"] = _closing(run)
        result["views"] = _views(run)
    os.replace(growing, path)
    return result


def _views(run: MappingRun) -> list[list[float]]:
    """By node: how far its first view was from node 0's perceptual SOM (in D_a), and it from node 0 (m)."""
    mapper = run.mapper
    if not isinstance(mapper, ThesisMapper):
        return []
    home = run.truth[0]
    return [[ratio, run.truth[node].distance_to(home)] for node, ratio in sorted(mapper.ratios.items())]


def _closing(run: MappingRun) -> dict[str, str]:
    """What eq. 3.33 would have done at the three thresholds of table 4.17: right, wrong or missed."""
    mapper = run.mapper
    if not isinstance(mapper, ThesisMapper) or not mapper.ratios:
        return {}
    home = run.truth[0]
    outcome = {}
    for name, threshold in (("T1", 0.5), ("T2", 1.0), ("T3", 2.0)):
        taken = next((node for node, ratio in sorted(mapper.ratios.items()) if ratio < threshold), None)
        outcome[name] = "missed" if taken is None else _judged(run.truth[taken], home)
    return outcome


def _judged(pose: Pose, home: Pose) -> str:
    return "right" if math.hypot(pose.x - home.x, pose.y - home.y) <= AT_NODE else "wrong"
