"""What runs on a map have in common: their map, how they are simulated, when a robot counts as lost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...session.requests import Simulation
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


def simulation_of(settings: Mapping[str, Any]) -> Simulation:
    """How a job that is about a map is simulated: with the map's profile and noise, and a seed of its own."""
    return Simulation(
        seed=int(settings["seed"]),
        profile=str(settings["map profile"]),
        noise=str(settings["map noise"]),
        noise_scale=float(settings["map noise_scale"]),
        engine=str(settings.get("engine", "dart")),
    )
