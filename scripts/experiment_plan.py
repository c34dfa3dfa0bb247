"""Which runs the experiments need: tables share them, and what is driven over a map waits for the map.

Seeds below 1000 are for tuning; reports use those from 1000 on. Half of the runs follow the right wall.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .campaign import Job, Result, Store, run_campaign
from .cli_errors import did_you_mean
from .experiment_mapping import mapping_job, run_mapping
from .experiment_traversal import run_traversal, traversal_job
from .experiment_version import TRAVERSALS, code_version
from .requests import SessionError

ENVIRONMENTS = ("env1", "env2", "env3")
SIDES = ("right", "left")
FIRST_SEED = 1000
REFERENCE, GLOBAL, LOCAL, UNCORRECTED, CORRECTED = "reference", "global", "local", "uncorrected", "corrected"

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
    """What to run. runs: an environment and profile, where local maps are built; global_runs: where not."""

    tables: tuple[str, ...]
    runs: int = 20
    global_runs: int = 50
    first_seed: int = FIRST_SEED
    environments: tuple[str, ...] = ENVIRONMENTS
    profiles: tuple[str, ...] = ("thesis", "default")

    @property
    def kinds(self) -> set[str]:
        """The kinds of runs that the tables need."""
        return {kind for table in self.tables for kind in NEEDS[table]}


def plan_for(
    names: Sequence[str], runs: int | None, global_runs: int | None, first_seed: int = FIRST_SEED
) -> Plan:
    """The plan of the experiments named: tables, `all`, or `smoke` (one run of one environment).

    Raises: SessionError for an unknown name.
    """
    tables: list[str] = []
    smoke = False
    for name in names:
        if name in ("all", "smoke"):
            tables += NEEDS
            smoke = smoke or name == "smoke"
        elif name in NEEDS:
            tables.append(name)
        else:
            known = ("all", "smoke", *NEEDS)
            raise SessionError(f"unknown experiment {name!r}{did_you_mean(name, known)} ({', '.join(known)})")
    few, many = (1, 1) if smoke else (20, 50)
    return Plan(
        tuple(table for table in NEEDS if table in tables),
        runs if runs is not None else few,
        global_runs if global_runs is not None else (runs if runs is not None else many),
        first_seed,
        ENVIRONMENTS[:1] if smoke else ENVIRONMENTS,
    )


@dataclass(slots=True)
class Outcome:
    """Results of runs and the jobs they are of, by (kind, environment, profile)."""

    results: dict[tuple[str, str, str], list[Result]] = field(default_factory=dict)
    jobs: dict[tuple[str, str, str], list[Job]] = field(default_factory=dict)

    def of(self, kind: str, environment: str, profile: str) -> list[Result]:
        """The results of one kind; none if it was not run."""
        return self.results.get((kind, environment, profile), [])


Progress = Callable[[str, int, int], None]


def run_plan(
    plan: Plan,
    folder: Path,
    *,
    processes: int = 1,
    dask: str | None = None,
    progress: Progress = lambda what, done, total: None,
) -> Outcome:
    """Runs what the plan needs and the work folder does not have yet. Raises: CampaignError."""
    folder.mkdir(parents=True, exist_ok=True)
    outcome = Outcome()
    work = Work(folder)

    def campaign(what: str, version: str, planned: Mapping[tuple[str, str, str], list[Job]]) -> None:
        jobs = [job for group in planned.values() for job in group]
        results = iter(
            run_campaign(
                jobs,
                work,
                processes=processes,
                store=Store(folder / f"{what}.jsonl", version),
                dask=dask,
                progress=lambda done, total: progress(what, done, total),
            )
        )
        for key, group in planned.items():
            outcome.jobs[key] = group
            outcome.results[key] = [next(results) for _ in group]

    campaign("mappings", code_version(), _mapping_jobs(plan))
    campaign("traversals", code_version(TRAVERSALS), _traversal_jobs(plan, outcome))
    return outcome


@dataclass(frozen=True, slots=True)
class Work:
    """What a process does with a job; sent to it, so nothing but the folder is in it."""

    folder: Path

    def __call__(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Runs the job and returns its figures."""
        run = {"map": run_mapping, "traverse": run_traversal}[str(settings["kind"])]
        return run(settings, self.folder)


def _mapping_jobs(plan: Plan) -> dict[tuple[str, str, str], list[Job]]:
    jobs: dict[tuple[str, str, str], list[Job]] = {}
    for world in plan.environments:
        for profile in plan.profiles:
            if REFERENCE in plan.kinds:
                jobs[REFERENCE, world, profile] = [
                    mapping_job(world, side, 0, profile, local_maps=False, noise="none") for side in SIDES
                ]
            if GLOBAL in plan.kinds:
                jobs[GLOBAL, world, profile] = [
                    mapping_job(world, side, seed, profile, local_maps=False)
                    for seed, side in _seeds(plan, plan.global_runs)
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
                    for seed, side in _seeds(plan, plan.runs)
                ]
    return jobs


def _seeds(plan: Plan, runs: int) -> Iterable[tuple[int, str]]:
    return ((plan.first_seed + k, SIDES[k % 2]) for k in range(runs))


def _traversal_jobs(plan: Plan, outcome: Outcome) -> dict[tuple[str, str, str], list[Job]]:
    """Traversals over the average map of each side: that whose position error is nearest to their mean."""
    jobs: dict[tuple[str, str, str], list[Job]] = {}
    for kind in (UNCORRECTED, CORRECTED):
        if kind not in plan.kinds:
            continue
        for world in plan.environments:
            for profile in plan.profiles:
                maps = average_maps(outcome, world, profile)
                jobs[kind, world, profile] = [
                    traversal_job(maps[side], seed, corrected=kind == CORRECTED)
                    for seed, side in _seeds(plan, plan.runs)
                    if side in maps
                ]
    return jobs


def average_maps(outcome: Outcome, world: str, profile: str) -> dict[str, Job]:
    """The mapping job of the average map, by side; a side none of whose runs got round has none."""
    key = (LOCAL, world, profile)
    found: dict[str, Job] = {}
    for side in SIDES:
        runs = [
            (job, float(result["position_error_m"]))
            for job, result in zip(outcome.jobs.get(key, []), outcome.of(*key), strict=True)
            if job.settings["side"] == side and result["finished"]
        ]
        if runs:
            mean = sum(error for _, error in runs) / len(runs)
            found[side] = min(runs, key=lambda run: (abs(run[1] - mean), run[0].key))[0]
    return found
