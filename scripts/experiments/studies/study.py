"""Studies: experiments beyond the thesis's tables, each a list of jobs and a section of a report.

A module adds one by a `Study` and, for runs of its own, by an entry in `running.RUNS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..campaign.campaign import Job, Result
from ..campaign.jobs import mapping_job, seeds, trip_job
from ..campaign.kinds import ENVIRONMENTS, FIRST_SEED
from ..campaign.running import ALONE, Running
from ..results.scores import Runs, score_values

Results = Mapping[str, Result]
"""By job key."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What of a study was asked for. runs: None for the study's own number; imported: names of worlds."""

    runs: int | None = None
    first_seed: int = FIRST_SEED
    environments: tuple[str, ...] = ENVIRONMENTS
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
        what = study.name if len(study.stages) == 1 else f"{study.name} {number} of {len(study.stages)}"
        results |= running.campaign(what, stage(asked, results).values(), folder)
    return results


def finished(jobs: Sequence[Job], results: Results) -> list[tuple[Job, Result]]:
    """The jobs that have a result, with it."""
    return [(job, results[job.key]) for job in jobs if job.key in results]


_TRIP_SEED = 500
"""Added to a map's seed for the traversals of it: they meet other noise than the map's."""


def mappings_of(
    world: str, asked: Asked, runs: int, profile: str = "default", *, local_maps: bool
) -> list[Job]:
    """The mappings of one world, the sides in turn. runs: how many where it was not asked."""
    return [
        mapping_job(world, side, seed, profile, local_maps=local_maps)
        for seed, side in seeds(asked.first_seed, asked.runs or runs)
    ]


def _trips(jobs: Sequence[Job], results: Results, *, corrected: bool) -> list[Job]:
    """The traversals of the maps of these mappings that got round."""
    return [
        trip_job("traverse", job, int(str(job.settings["seed"])) + _TRIP_SEED, corrected=corrected)
        for job, result in finished(jobs, results)
        if result["finished"] and (job.settings["local_maps"] or not corrected)
    ]


@dataclass(frozen=True, slots=True)
class MapAndDrive:
    """Mappings, by what they are for, and then five traversals of each map that got round.

    corrected: of a name, whether its maps are driven from node to node (False), with local maps (True), or
    both.
    """

    mappings: Callable[[Asked], Mapping[str, list[Job]]]
    corrected: Callable[[str], tuple[bool, ...]]

    @property
    def stages(self) -> tuple[Stage, ...]:
        """First all mappings, then the traversals."""
        return (lambda asked, results: self.mappings(asked), self._traversals)

    def _traversals(self, asked: Asked, results: Results) -> Groups:
        return {
            f"{name}, {corrected}": _trips(jobs, results, corrected=corrected)
            for name, jobs in self.mappings(asked).items()
            for corrected in self.corrected(name)
        }

    def found(self, asked: Asked, results: Results) -> dict[str, Runs]:
        """What has finished, by name."""

        def runs(jobs: list[Job]) -> Runs:
            driven = (_trips(jobs, results, corrected=corrected) for corrected in (False, True))
            return Runs(*([result for _, result in finished(group, results)] for group in (jobs, *driven)))

        return {name: runs(jobs) for name, jobs in self.mappings(asked).items()}

    def values(self, asked: Asked, results: Results) -> dict[str, Any]:
        """The scores of what has finished, by name, as JSON values."""
        return {name: score_values(runs) for name, runs in self.found(asked, results).items()}
