"""Study `variants`: do the targets hold in rooms turned, mirrored, scaled or imported, and with more noise?

Each map is driven by runs of its own: a map a seed, then its five traversals without and with local maps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..campaign.campaign import Job
from ..campaign.running import seeds
from ..campaign.summary import markdown_table
from ..report.scores import SCORES, Runs, cell, closed, driven, failures, kept, score_values
from ..runs.mapping import mapping_job
from ..runs.traversal import traversal_job
from ..runs.worlds import CHANGES, NOISIER, split
from .study import Asked, Groups, Results, Study, finished

RUNS = 2
"""Runs a world where not asked otherwise: one a side."""
_TRIP_SEED = 500
"""Added to a map's seed for the runs over it: they meet other noise than the map's."""


def worlds(asked: Asked) -> list[str]:
    """The variants of the environments, and the imported worlds."""
    return [f"{world} {change}" for change in CHANGES for world in asked.environments] + list(asked.imported)


def maps(world: str, asked: Asked, profile: str = "default", runs: int = RUNS) -> list[Job]:
    """The mappings of one world. Imported ones get no local maps, to save time."""
    local = world not in asked.imported
    return [
        mapping_job(world, side, seed, profile, local_maps=local)
        for seed, side in seeds(asked.first_seed, asked.runs or runs)
    ]


def trips(jobs: Sequence[Job], results: Results, *, corrected: bool) -> list[Job]:
    """The traversals over the maps of these mappings that got round."""
    return [
        traversal_job(job, int(str(job.settings["seed"])) + _TRIP_SEED, corrected=corrected)
        for job, result in finished(jobs, results)
        if result["finished"] and (job.settings["local_maps"] or not corrected)
    ]


def runs_of(jobs: Sequence[Job], results: Results) -> Runs:
    """What has finished of mappings and the traversals over them."""

    def group(jobs: Sequence[Job]) -> list[dict[str, Any]]:
        return [result for _, result in finished(jobs, results)]

    return Runs(
        group(jobs),
        group(trips(jobs, results, corrected=False)),
        group(trips(jobs, results, corrected=True)),
    )


def _mappings(asked: Asked, results: Results) -> Groups:
    return {world: maps(world, asked) for world in worlds(asked)}


def _trips(asked: Asked, results: Results) -> Groups:
    return {
        f"{world}, {corrected}": trips(maps(world, asked), results, corrected=corrected)
        for world in worlds(asked)
        for corrected in (False, True)
    }


def _found(asked: Asked, results: Results) -> Mapping[str, Runs]:
    return {world: runs_of(maps(world, asked), results) for world in worlds(asked)}


def _environment(world: str) -> int:
    """The environment whose published figures a world is held against; the third for those of others."""
    return {"env1": 0, "env2": 1}.get(split(world)[0], 2)


def _report(asked: Asked, results: Results) -> str:
    header = [
        "world",
        "closed rightly",
        *(score.name for score in SCORES),
        "not corrected",
        "corrected",
        "kept",
    ]
    lines, lost = [], []
    for world, runs in _found(asked, results).items():
        beyond = kept(runs, _environment(world))
        lines.append(
            [
                world,
                closed(runs.maps),
                *(cell(score.values(runs)) for score in SCORES),
                driven(runs.uncorrected),
                driven(runs.corrected),
                ("yes" if not beyond else "**no**: " + ", ".join(beyond)) if runs.maps else "",
            ]
        )
        lost += failures(world, runs)
    text = (
        f"The whole chain with profile `default`, {asked.runs or RUNS} runs a world (seeds from "
        f"{asked.first_seed}, the sides in turn): mapping with local maps, then five traversals of each "
        "map without and with local maps driven (imported worlds: without local maps). *rotated*: by 17 "
        f"degrees; *smaller*, *larger*: by 20 %; *noisier*: all noise {NOISIER:g} times the preset. Cells: "
        "mean (worst) over runs, nodes or places; the last columns count completed runs of five "
        "traversals. *Kept*: every mean is within the target plus a third of its margin over the "
        "published figure, every loop closed rightly (or called ambiguous), no run lost."
    )
    parts = [text, markdown_table(header, lines)]
    if lost:
        parts.append("Runs that did not do all they were to:\n\n" + "\n".join(lost))
    return "\n\n".join(parts)


def _values(asked: Asked, results: Results) -> Any:
    return {world: score_values(runs) for world, runs in _found(asked, results).items()}


VARIANTS = Study(
    "variants", "Variants of the environments, and imported worlds", (_mappings, _trips), _report, _values
)
