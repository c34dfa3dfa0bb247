"""Study `ablation`: profile `default` without one remedy at a time; what each is worth, and what it costs.

Remedies of local maps are measured on mappings with local maps and the traversals that drive them; the
others, cheaper, on mappings without and on traversals from node to node.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...session.profiles import REMEDIES, WITHOUT
from ..campaign.campaign import Job
from ..campaign.running import seeds
from ..campaign.summary import markdown_table
from ..report.scores import SCORES, Runs, cell, closed, driven, failures, score_values
from ..runs.mapping import mapping_job
from .study import Asked, Groups, Results, Study
from .variants import maps, runs_of, trips

RUNS = 4
OF_LOCAL_MAPS = ("landmarks", "compass", "coming back", "mismatch", "reflexes")
OF_THE_BOUNDARY = ("recognized corners", "mismatch", "square rooms", "confirmation")
WHOLE = "default"


def _profiles(remedies: tuple[str, ...]) -> list[str]:
    return [WHOLE, *(f"{WHOLE}{WITHOUT}{remedy}" for remedy in remedies if remedy in REMEDIES)]


def _local(asked: Asked, profile: str) -> list[Job]:
    return [job for world in asked.environments[:1] for job in maps(world, asked, profile, RUNS)]


def _boundary(asked: Asked, profile: str) -> list[Job]:
    return [
        mapping_job(world, side, seed, profile, local_maps=False)
        for world in asked.environments
        for seed, side in seeds(asked.first_seed, asked.runs or RUNS)
    ]


def _mappings(asked: Asked, results: Results) -> Groups:
    groups = {f"local, {profile}": _local(asked, profile) for profile in _profiles(OF_LOCAL_MAPS)}
    return groups | {
        f"boundary, {profile}": _boundary(asked, profile) for profile in _profiles(OF_THE_BOUNDARY)
    }


def _trips(asked: Asked, results: Results) -> Groups:
    groups = {
        f"local, {profile}": trips(_local(asked, profile), results, corrected=True)
        for profile in _profiles(OF_LOCAL_MAPS)
    }
    return groups | {
        f"boundary, {profile}": trips(_boundary(asked, profile), results, corrected=False)
        for profile in _profiles(OF_THE_BOUNDARY)
    }


def _found(asked: Asked, results: Results) -> dict[str, dict[str, Runs]]:
    return {
        "local": {profile: runs_of(_local(asked, profile), results) for profile in _profiles(OF_LOCAL_MAPS)},
        "boundary": {
            profile: runs_of(_boundary(asked, profile), results) for profile in _profiles(OF_THE_BOUNDARY)
        },
    }


def _table(found: Mapping[str, Runs], names: tuple[str, ...], *, local: bool) -> str:
    scores = [score for score in SCORES if score.name in names]
    header = ["profile", "closed rightly", *(score.name for score in scores), "traversals completed"]
    header += ["collisions", "mapping (s)", "traversals (s)"]
    lines = []
    for profile, runs in found.items():
        driving = runs.corrected if local else runs.uncorrected
        lines.append(
            [
                profile.removeprefix(WHOLE + " ") or profile,
                closed(runs.maps),
                *(cell(score.values(runs)) for score in scores),
                driven(driving),
                str(sum(int(run["collisions"]) for run in (*runs.maps, *driving))),
                _seconds(runs.maps),
                _seconds(driving),
            ]
        )
    return markdown_table(header, lines)


def _seconds(runs: Any) -> str:
    times = [float(run["sim_time_s"]) for run in runs]
    return f"{sum(times) / len(times):.0f}" if times else "none"


def _report(asked: Asked, results: Results) -> str:
    found = _found(asked, results)
    runs = asked.runs or RUNS
    lost = [
        line
        for group in found.values()
        for profile, these in group.items()
        for line in failures(profile, these)
    ]
    parts = [
        "Profile `default` without one of its remedies, the others as they are. Cells: mean (worst); seconds "
        "are simulated, a run on average. A run that is lost ends early: its time says nothing of the price.",
        f"### Remedies of local maps\n\n{asked.environments[0]}, {runs} runs (seeds from {asked.first_seed}"
        "): mapping with local maps, then five traversals that drive them.",
        _table(
            found["local"],
            (
                "after exploring (cm)",
                "after exploring (deg)",
                "map error (cm)",
                "end, corrected (cm)",
                "heading on entry (deg)",
            ),
            local=True,
        ),
        f"### Remedies of the boundary\n\n{', '.join(asked.environments)}, {runs} runs each: mapping without "
        "local maps, then five traversals from node to node.",
        _table(found["boundary"], ("map error (cm)", "end, not corrected (cm)"), local=False),
    ]
    if lost:
        parts.append("Runs that did not do all they were to:\n\n" + "\n".join(lost))
    return "\n\n".join(parts)


def _values(asked: Asked, results: Results) -> Any:
    return {
        kind: {profile: score_values(runs) for profile, runs in group.items()}
        for kind, group in _found(asked, results).items()
    }


ABLATION = Study("ablation", "Ablation: each remedy off in turn", (_mappings, _trips), _report, _values)
