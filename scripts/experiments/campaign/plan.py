"""Which tables of the thesis are asked for, how many runs that takes, and what has come of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ....files.messages import unknown
from .campaign import CampaignError, Job, Result
from .kinds import ENVIRONMENTS, FIRST_SEED, GLOBAL, NEEDS, REFERENCE

Key = tuple[str, str, str]
"""Kind of run, environment, profile."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What to run. runs: an environment where local maps are built; global_runs: where not.

    thesis_runs, thesis_global_runs: of profile `thesis`, None for as many as of `default`.
    """

    tables: tuple[str, ...]
    runs: int = 20
    global_runs: int = 50
    first_seed: int = FIRST_SEED
    environments: tuple[str, ...] = ENVIRONMENTS
    profiles: tuple[str, ...] = ("thesis", "default")
    thesis_runs: int | None = None
    thesis_global_runs: int | None = None

    @property
    def kinds(self) -> set[str]:
        """The kinds of runs that the tables need."""
        return {kind for table in self.tables for kind in NEEDS[table]}

    def runs_of(self, kind: str, profile: str) -> int:
        """How many runs of a kind there are an environment, in one profile."""
        if kind == REFERENCE:
            return 2  # one a side: without noise all others would be the same
        own = self.thesis_global_runs if kind == GLOBAL else self.thesis_runs
        if profile == "thesis" and own is not None:
            return own
        return self.global_runs if kind == GLOBAL else self.runs


def plan_for(
    names: Sequence[str],
    runs: int | None,
    global_runs: int | None,
    first_seed: int = FIRST_SEED,
    others: Sequence[str] = (),
) -> Plan:
    """The plan of the experiments named: tables, `all`, or `smoke` (one run of one environment).

    others: what else might have been meant by an unknown name.

    Raises: CampaignError for an unknown name.
    """
    known = ("all", "smoke", *NEEDS, *others)
    for name in names:
        if name not in known[: 2 + len(NEEDS)]:
            raise CampaignError(unknown("experiment", name, known))
    smoke = "smoke" in names
    few, many = (1, 1) if smoke else (20, 50)
    return Plan(
        tuple(table for table in NEEDS if smoke or "all" in names or table in names),
        runs if runs is not None else few,
        global_runs if global_runs is not None else (runs if runs is not None else many),
        first_seed,
        ENVIRONMENTS[:1] if smoke else ENVIRONMENTS,
    )


@dataclass(slots=True)
class Outcome:
    """Results of finished runs and the jobs they are of, by (kind, environment, profile).

    planned: how many there are to be.
    """

    results: dict[Key, list[Result]] = field(default_factory=dict)
    jobs: dict[Key, list[Job]] = field(default_factory=dict)
    planned: dict[Key, int] = field(default_factory=dict)

    def of(self, kind: str, environment: str, profile: str) -> list[Result]:
        """The results of one kind; none if it was not run."""
        return self.results.get((kind, environment, profile), [])

    def runs(self, kind: str, environment: str, profile: str) -> list[tuple[Job, Result]]:
        """The same, each with its job."""
        jobs = self.jobs.get((kind, environment, profile), [])
        return list(zip(jobs, self.of(kind, environment, profile), strict=True))

    def take(self, planned: Mapping[Key, Sequence[Job]], results: Mapping[str, Result]) -> None:
        """Takes over what has finished of what is planned."""
        for key, group in planned.items():
            self.jobs[key] = [job for job in group if job.key in results]
            self.results[key] = [results[job.key] for job in self.jobs[key]]
            self.planned[key] = len(group)

    def complete(self, key: Key) -> bool:
        """Whether all planned runs of one kind have finished."""
        return len(self.results.get(key, [])) == self.planned.get(key, -1)
