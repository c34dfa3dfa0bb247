"""Which runs the experiments need: tables share them, and what is driven over a map waits for the map.

Seeds below FIRST_SEED are for tuning; reports use those from there. Half of the runs follow the right wall.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from ...cli.errors import did_you_mean
from ...session.requests import SessionError
from ..runs.mapping import mapping_job
from ..runs.traversal import traversal_job
from .campaign import Job, Result
from .running import ALONE, SIDES, Running, expected_cost, paced, seeds

ENVIRONMENTS = ("env1", "env2", "env3")
FIRST_SEED = 4000
REFERENCE, GLOBAL, LOCAL, UNCORRECTED, CORRECTED = "reference", "global", "local", "uncorrected", "corrected"
MAPS_FROM = 6
"""Mapping runs that the average maps are picked from."""
Key = tuple[str, str, str]
"""Kind of run, environment, profile."""

NEEDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "table-4.2": (REFERENCE, GLOBAL),
        "table-4.3": (GLOBAL,),
        "table-4.5": (LOCAL,),
        "table-4.6": (REFERENCE, LOCAL),
        "table-4.10": (LOCAL,),
        "table-4.12": (LOCAL, UNCORRECTED),
        "table-4.14": (LOCAL, CORRECTED),
        "table-4.15": (LOCAL, CORRECTED),
        "table-4.16": (LOCAL, CORRECTED),
        "table-4.18": (LOCAL,),
    }
)
"""The kinds of runs that each table is made of."""


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
            return len(SIDES)
        own = self.thesis_global_runs if kind == GLOBAL else self.thesis_runs
        if profile == "thesis" and own is not None:
            return own
        return self.global_runs if kind == GLOBAL else self.runs

    @property
    def in_order(self) -> tuple[str, ...]:
        """The profiles as they are run: `default` first."""
        return tuple(sorted(self.profiles))


def plan_for(
    names: Sequence[str],
    runs: int | None,
    global_runs: int | None,
    first_seed: int = FIRST_SEED,
    others: Sequence[str] = (),
) -> Plan:
    """The plan of the experiments named: tables, `all`, or `smoke` (one run of one environment).

    others: what else might have been meant by an unknown name.

    Raises: SessionError for an unknown name.
    """
    tables: list[str] = []
    for name in names:
        if name in ("all", "smoke"):
            tables += NEEDS
        elif name in NEEDS:
            tables.append(name)
        else:
            known = ("all", "smoke", *NEEDS, *others)
            raise SessionError(f"unknown experiment {name!r}{did_you_mean(name, known)} ({', '.join(known)})")
    few, many = (1, 1) if "smoke" in names else (20, 50)
    return Plan(
        tuple(table for table in NEEDS if table in tables),
        runs if runs is not None else few,
        global_runs if global_runs is not None else (runs if runs is not None else many),
        first_seed,
        ENVIRONMENTS[:1] if "smoke" in names else ENVIRONMENTS,
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

    def take(self, planned: Mapping[Key, Sequence[Job]], results: Mapping[str, Result]) -> None:
        """Takes over what has finished of what is planned."""
        for key, group in planned.items():
            finished = [job for job in group if job.key in results]
            self.jobs[key] = finished
            self.results[key] = [results[job.key] for job in finished]
            self.planned[key] = len(group)

    def complete(self, key: Key) -> bool:
        """Whether all planned runs of one kind have finished."""
        return len(self.results.get(key, [])) == self.planned.get(key, -1)


def run_plan(plan: Plan, folder: Path, running: Running = ALONE) -> Outcome:
    """Runs what the plan needs and the work folder does not have yet. Raises: CampaignError.

    Profile by profile: first the runs that the average maps are picked from, then all others at the same pace
    for every kind and environment, so that an interrupted campaign has something of each.
    """
    outcome = Outcome()
    for profile in plan.in_order:
        mappings = _mapping_jobs(plan, profile)
        first = {key: group[:MAPS_FROM] for key, group in mappings.items() if key[0] in (LOCAL, REFERENCE)}
        jobs = [job for group in first.values() for job in group]
        jobs.sort(key=expected_cost, reverse=True)
        results = running.campaign(f"{profile}, first maps", jobs, folder)
        outcome.take(first, results)
        planned = {**mappings, **_traversal_jobs(plan, outcome, profile)}
        outcome.take(planned, running.campaign(f"{profile}", paced(planned.values()), folder))
    return outcome


def _mapping_jobs(plan: Plan, profile: str) -> dict[Key, list[Job]]:
    jobs: dict[Key, list[Job]] = {}
    for world in plan.environments:
        if REFERENCE in plan.kinds:
            jobs[REFERENCE, world, profile] = [
                mapping_job(world, side, 0, profile, local_maps=False, noise="none") for side in SIDES
            ]
        if GLOBAL in plan.kinds:
            jobs[GLOBAL, world, profile] = [
                mapping_job(world, side, seed, profile, local_maps=False)
                for seed, side in seeds(plan.first_seed, plan.runs_of(GLOBAL, profile))
            ]
        if LOCAL in plan.kinds:
            jobs[LOCAL, world, profile] = [
                # The first run's samples also train every configuration of table 4.8.
                mapping_job(
                    world,
                    side,
                    seed,
                    profile,
                    local_maps=True,
                    training=profile == "default" and seed == plan.first_seed,
                )
                for seed, side in seeds(plan.first_seed, plan.runs_of(LOCAL, profile))
            ]
    return jobs


def _traversal_jobs(plan: Plan, outcome: Outcome, profile: str) -> dict[Key, list[Job]]:
    """Traversals over the average map of each side; none before all maps to pick from are there."""
    jobs: dict[Key, list[Job]] = {}
    for kind in (UNCORRECTED, CORRECTED):
        if kind not in plan.kinds:
            continue
        for world in plan.environments:
            ready = outcome.complete((LOCAL, world, profile))
            maps = average_maps(outcome, world, profile) if ready else {}
            jobs[kind, world, profile] = [
                traversal_job(maps[side], seed, corrected=kind == CORRECTED)
                for seed, side in seeds(plan.first_seed, plan.runs_of(kind, profile))
                if side in maps
            ]
    return jobs


def average_maps(outcome: Outcome, world: str, profile: str) -> dict[str, Job]:
    """The mapping job of the average map, by side: whose position error is nearest to their mean.

    Of the first six runs, as many as the thesis had to pick from: more runs so change no map that was driven.
    A side none of whose runs got round has none.
    """
    key = (LOCAL, world, profile)
    first = list(zip(outcome.jobs.get(key, []), outcome.of(*key), strict=True))[:MAPS_FROM]
    found: dict[str, Job] = {}
    for side in SIDES:
        runs = [
            (job, float(result["position_error_m"]))
            for job, result in first
            if job.settings["side"] == side and result["finished"]
        ]
        if runs:
            mean = sum(error for _, error in runs) / len(runs)
            found[side] = min(runs, key=lambda run: (abs(run[1] - mean), run[0].key))[0]
    return found
