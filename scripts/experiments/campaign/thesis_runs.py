"""The runs of the thesis's tables: tables share them, and what is driven over a map waits for the map."""

from __future__ import annotations

from pathlib import Path

from .campaign import Job
from .jobs import SIDES, mapping_job, seeds, trip_job
from .kinds import CORRECTED, GLOBAL, LOCAL, REFERENCE, UNCORRECTED
from .plan import Key, Outcome, Plan
from .running import ALONE, Running

MAPS_FROM = 6
"""Mapping runs that the average maps are picked from: as many as the thesis had."""


def run_plan(plan: Plan, folder: Path, running: Running = ALONE) -> Outcome:
    """Runs what the plan needs and the work folder does not have yet. Raises: CampaignError.

    Profile by profile, `default` first: first the runs that the average maps are picked from, then all others
    at the same pace for every kind and environment, so that an interrupted campaign has something of each.
    """
    outcome = Outcome()
    for profile in sorted(plan.profiles):
        mappings = _mapping_jobs(plan, profile)
        first = {key: group[:MAPS_FROM] for key, group in mappings.items() if key[0] in (LOCAL, REFERENCE)}
        outcome.take(first, running.campaign(f"{profile}, first maps", first.values(), folder))
        planned = {**mappings, **_traversal_jobs(plan, outcome, profile)}
        outcome.take(planned, running.campaign(profile, planned.values(), folder))
    return outcome


def _mapping_jobs(plan: Plan, profile: str) -> dict[Key, list[Job]]:
    return {
        (kind, world, profile): [
            # The first run's samples also train every configuration of table 4.8.
            mapping_job(
                world,
                side,
                0 if kind == REFERENCE else seed,
                profile,
                local_maps=kind == LOCAL,
                noise="none" if kind == REFERENCE else "thesis",
                training=kind == LOCAL and profile == "default" and seed == plan.first_seed,
            )
            for seed, side in seeds(plan.first_seed, plan.runs_of(kind, profile))
        ]
        for world in plan.environments
        for kind in (REFERENCE, GLOBAL, LOCAL)
        if kind in plan.kinds
    }


def _traversal_jobs(plan: Plan, outcome: Outcome, profile: str) -> dict[Key, list[Job]]:
    """Traversals over the average map of each side; none before all maps to pick from are there."""
    jobs: dict[Key, list[Job]] = {}
    for world in plan.environments:
        ready = outcome.complete((LOCAL, world, profile))
        maps = average_maps(outcome, world, profile) if ready else {}
        for kind in (kind for kind in (UNCORRECTED, CORRECTED) if kind in plan.kinds):
            jobs[kind, world, profile] = [
                trip_job("traverse", maps[side], seed, corrected=kind == CORRECTED)
                for seed, side in seeds(plan.first_seed, plan.runs_of(kind, profile))
                if side in maps
            ]
    return jobs


def average_maps(outcome: Outcome, world: str, profile: str) -> dict[str, Job]:
    """The mapping job of the average map, by side: whose position error is nearest to their mean.

    Of the first six runs: more runs so change no map that was driven. A side none of whose runs got round has
    none.
    """
    found: dict[str, Job] = {}
    for side in SIDES:
        errors = {
            job.key: (float(result["position_error_m"]), job)
            for job, result in outcome.runs(LOCAL, world, profile)[:MAPS_FROM]
            if job.settings["side"] == side and result["finished"]
        }
        if errors:
            mean = sum(error for error, _ in errors.values()) / len(errors)
            found[side] = errors[min(errors, key=lambda key: (abs(errors[key][0] - mean), key))][1]
    return found
