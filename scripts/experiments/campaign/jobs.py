"""The jobs of experiments: all settings that a run depends on, by kind of run.

A job that is about a map (traversals, unknown starts, changed worlds) names the mapping that makes it: the
settings of that mapping are among its own, each behind "map ".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..worlds.names import noise_scale
from .campaign import Job, Scalar

SIDES = ("right", "left")
DROPS = ("wall", "open")
"""Where a robot that is not told its start is dropped: near a wall, or away from all."""
CHANGES = ("added", "removed", "moved", "shut")
"""What is done to a world after it was mapped: to a box of it, or to a passage."""
_OF_MAP = "map "


def mapping_job(
    world: str,
    side: str,
    seed: int,
    profile: str,
    *,
    local_maps: bool,
    noise: str = "thesis",
    training: bool = False,
    islands: bool = False,
) -> Job:
    """A mapping. world: see `worlds.names`. training: also train SOMs in all configurations."""
    settings: dict[str, Scalar] = {
        "kind": "map",
        "world": world,
        "side": side,
        "seed": seed,
        "profile": profile,
        "local_maps": local_maps,
        "noise": noise,
        "noise_scale": noise_scale(world),
        "training": training,
    }
    return Job({**settings, "islands": True} if islands else settings)


def trip_job(kind: str, map_job: Job, seed: int, **values: Scalar) -> Job:
    """A run on the map of a mapping job. values: settings of its kind, as the kind's module names them."""
    of_map = {f"{_OF_MAP}{name}": value for name, value in map_job.settings.items()}
    return Job({"kind": kind, "seed": seed, **values, **of_map})


def map_job_of(settings: Mapping[str, Any]) -> Job:
    """The mapping whose map a job is about."""
    return Job({name[len(_OF_MAP) :]: value for name, value in settings.items() if name.startswith(_OF_MAP)})


def map_path(folder: Path, job: Job) -> Path:
    """Where the map of a mapping job is kept in the work folder."""
    return folder / "maps" / f"{job.key}.tolman"


def seeds(first: int, runs: int) -> Iterator[tuple[int, str]]:
    """Seeds and sides of runs: every second one follows the left wall."""
    return ((first + k, SIDES[k % 2]) for k in range(runs))
