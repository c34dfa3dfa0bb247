"""Studies: experiments beyond the thesis's tables, each a list of jobs and a section of a report.

A module adds one by a `Study` and, for runs of its own, by an entry in `running.RUNS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..campaign.campaign import Job, Result
from ..campaign.plan import FIRST_SEED
from ..campaign.running import ALONE, Running, paced

Results = Mapping[str, Result]
"""By job key."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What of a study was asked for. runs: None for the study's own number; imported: names of worlds."""

    runs: int | None = None
    first_seed: int = FIRST_SEED
    environments: tuple[str, ...] = ("env1", "env2", "env3")
    imported: tuple[str, ...] = ()


Groups = Mapping[str, Sequence[Job]]
"""Jobs by what they are for; each group is run at the same pace."""
Stage = Callable[[Asked, Results], Groups]
"""The jobs of one stage; it may look at the results of the stages before."""


@dataclass(frozen=True, slots=True)
class Study:
    """One study. report: its section in Markdown; values: the same as JSON; both of what has finished."""

    name: str
    title: str
    stages: tuple[Stage, ...]
    report: Callable[[Asked, Results], str]
    values: Callable[[Asked, Results], Any]


def run_study(study: Study, asked: Asked, folder: Path, running: Running = ALONE) -> dict[str, Result]:
    """Runs what the study needs and the work folder does not have yet; results by job key.

    Raises: CampaignError.
    """
    results: dict[str, Result] = {}
    for number, stage in enumerate(study.stages, 1):
        groups = stage(asked, results)
        what = study.name if len(study.stages) == 1 else f"{study.name} {number} of {len(study.stages)}"
        results |= running.campaign(what, paced(list(groups.values())), folder)
    return results


def finished(jobs: Sequence[Job], results: Results) -> list[tuple[Job, Result]]:
    """The jobs that have a result, with it."""
    return [(job, results[job.key]) for job in jobs if job.key in results]
