"""How experiments' jobs are run: what each kind does, in which order, with which version of the code."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .campaign import Job, Progress, Result, Store, run_campaign
from .version import code_version

RUNS: Mapping[str, str] = MappingProxyType(
    {
        "map": "mapping:run_mapping",
        "traverse": "traversal:run_traversal",
        "unknown-start": "unknown_start:run_unknown_start",
        "changed-world": "changed_world:run_changed_world",
    }
)
"""What makes a run of a job, by its setting `kind`: module of `runs`, and the function in it.

The function takes the job's settings and the work folder, and returns figures. It is imported where it is
called: in the process that makes the run.
"""


@dataclass(frozen=True, slots=True)
class Running:
    """How campaigns are run, as in `run_campaign`. until: no run is begun after it (`time.monotonic`)."""

    processes: int = 1
    dask: str | None = None
    until: float | None = None
    progress: Callable[[str, Progress], None] = lambda what, progress: None
    failed: Callable[[Job, str], None] | None = None

    def campaign(self, what: str, groups: Iterable[Sequence[Job]], folder: Path) -> dict[str, Result]:
        """Runs all groups at the same pace, but for what the work folder has; results by job key.

        what: told with the progress. Raises: CampaignError.
        """
        folder.mkdir(parents=True, exist_ok=True)
        return run_campaign(
            paced(groups),
            partial(run_job, folder=folder),
            processes=self.processes,
            store=Store(folder / "runs.jsonl", version_of),
            progress=lambda progress: self.progress(what, progress),
            cost=expected_cost,
            until=self.until,
            dask=self.dask,
            failed=self.failed,
        )


ALONE = Running()
"""One process, no limit, nobody to tell."""


def run_job(settings: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """What a process does with a job: runs it and returns its figures."""
    module, _, function = RUNS[str(settings["kind"])].partition(":")
    run = getattr(importlib.import_module(f"...runs.{module}", __name__), function)
    figures: dict[str, Any] = run(settings, folder)
    return figures


def version_of(settings: Mapping[str, Any]) -> str:
    """The version of the code that a job's result depends on; nothing for a kind that there is no more."""
    kind = str(settings.get("kind"))
    return code_version(f"experiments.runs.{RUNS[kind].partition(':')[0]}") if kind in RUNS else ""


def versions() -> dict[str, str]:
    """The version of the code by kind of run."""
    return {kind: version_of({"kind": kind}) for kind in RUNS}


def paced(groups: Iterable[Sequence[Job]]) -> list[Job]:
    """The jobs of all groups at the same pace: the k-th of n at k / n, where equal the longest first."""
    placed = [
        (k / len(group), -expected_cost(job), job.key, job) for group in groups for k, job in enumerate(group)
    ]
    return [job for *_, job in sorted(placed, key=lambda entry: entry[:3])]


_COSTS = {"env1": 1.0, "env2": 2.4, "env3": 2.8}


def expected_cost(job: Job) -> float:
    """About what a job takes, in thousands of simulated seconds: to order jobs and to guess the time left."""
    settings = job.settings
    world = str(settings.get("world", settings.get("map world", ""))).partition(" ")[0]
    if settings["kind"] == "traverse":
        lost_soon = settings["map profile"] == "thesis"
        cost = 0.85 if not settings["corrected"] else 0.3 if lost_soon else 3.5
    elif settings["kind"] == "map":
        cost = 1.8 if settings["local_maps"] else 0.2
    else:
        cost = 1.0
    return cost * _COSTS.get(world, 2.0)
