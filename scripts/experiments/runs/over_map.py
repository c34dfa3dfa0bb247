"""What runs on a map have in common: their map, how they are simulated, when a robot counts as lost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....maps.hybrid_map import HybridMap
from ....world.robot import Pose
from ...session.requests import RunSettings
from ...session.truth import read_map_truth
from ..campaign.jobs import map_job_of, map_path
from .mapping import run_mapping

LOST_BEYOND = 0.15
"""Meters from the node it says it is at beyond which a robot is lost."""


def mapped_for(settings: Mapping[str, Any], folder: Path) -> Path:
    """The map that a job is about; it is mapped if the folder does not have it yet."""
    map_job = map_job_of(settings)
    path = map_path(folder, map_job)
    if not path.exists():
        run_mapping(map_job.settings, folder)
    return path


def read_map(path: Path) -> tuple[HybridMap, Mapping[int, Pose]]:
    """A map, and where its nodes truly are (m, rad, world frame)."""
    truth = read_map_truth(path)
    assert truth is not None  # it was made here
    return HybridMap.load(path), truth.nodes


def simulated_as(settings: Mapping[str, Any]) -> RunSettings:
    """How a job that is about a map is simulated: with the map's profile and noise, and a seed of its own."""
    return RunSettings(
        seed=int(settings["seed"]),
        profile=str(settings["map profile"]),
        noise=str(settings["map noise"]),
        noise_scale=float(settings["map noise_scale"]),
        engine=str(settings.get("engine", "dart")),
    )
