"""Study `ablation`: profile `default` without one remedy at a time; what each is worth, and what it costs.

Remedies of local maps are measured on mappings with local maps and the traversals that drive them; the
others, cheaper, on mappings without and on traversals from node to node.
"""

from __future__ import annotations

from typing import Any

from ...session.profiles import REMEDIES, WITHOUT
from ..campaign.campaign import Job
from ..results.scores import Runs, driven, runs_table, score_values, with_failures
from .study import Asked, MapAndDrive, Results, Study, mappings_of

RUNS = 4
OF_LOCAL_MAPS = ("landmarks", "compass", "coming back", "mismatch", "reflexes")
OF_THE_BOUNDARY = ("recognized corners", "mismatch", "square rooms", "confirmation")
WHOLE = "default"
_LOCAL, _BOUNDARY = "local", "boundary"


def _profiles(remedies: tuple[str, ...]) -> list[str]:
    return [WHOLE, *(f"{WHOLE}{WITHOUT}{remedy}" for remedy in remedies if remedy in REMEDIES)]


def _mappings(asked: Asked) -> dict[str, list[Job]]:
    """By kind and profile; local maps in the first environment alone."""
    local = {
        f"{_LOCAL}, {profile}": [
            job
            for world in asked.environments[:1]
            for job in mappings_of(world, asked, RUNS, profile, local_maps=True)
        ]
        for profile in _profiles(OF_LOCAL_MAPS)
    }
    return local | {
        f"{_BOUNDARY}, {profile}": [
            job
            for world in asked.environments
            for job in mappings_of(world, asked, RUNS, profile, local_maps=False)
        ]
        for profile in _profiles(OF_THE_BOUNDARY)
    }


_DRIVES = MapAndDrive(_mappings, lambda name: (name.startswith(_LOCAL),))


def _found(asked: Asked, results: Results) -> dict[str, dict[str, Runs]]:
    """By kind, then profile."""
    found = _DRIVES.found(asked, results)
    return {
        kind: {name.removeprefix(f"{kind}, "): runs for name, runs in found.items() if name.startswith(kind)}
        for kind in (_LOCAL, _BOUNDARY)
    }


def _table(found: dict[str, Runs], *scores: str) -> str:
    columns = {
        "traversals completed": lambda profile, runs: driven(runs.trips),
        "collisions": lambda profile, runs: str(runs.collisions),
        "mapping (s)": lambda profile, runs: _seconds(runs.maps),
        "traversals (s)": lambda profile, runs: _seconds(runs.trips),
    }
    short = {profile.removeprefix(WHOLE + " ") or profile: runs for profile, runs in found.items()}
    return runs_table("profile", short, scores, columns)


def _seconds(runs: Any) -> str:
    times = [float(run["sim_time_s"]) for run in runs]
    return f"{sum(times) / len(times):.0f}" if times else "none"


def _report(asked: Asked, results: Results) -> str:
    found = _found(asked, results)
    runs = asked.runs or RUNS
    local = ("after exploring (cm)", "after exploring (deg)", "map error (cm)", "end, corrected (cm)")
    parts = [
        "Profile `default` without one of its remedies, the others as they are. Cells: mean (worst); seconds "
        "are simulated, a run on average. A run that is lost ends early: its time says nothing of the price.",
        f"### Remedies of local maps\n\n{asked.environments[0]}, {runs} runs (seeds from {asked.first_seed}"
        "): mapping with local maps, then five traversals that drive them.",
        _table(found[_LOCAL], *local, "heading on entry (deg)"),
        f"### Remedies of the boundary\n\n{', '.join(asked.environments)}, {runs} runs each: mapping without "
        "local maps, then five traversals from node to node.",
        _table(found[_BOUNDARY], "map error (cm)", "end, not corrected (cm)"),
    ]
    return with_failures(parts, *found.values())


def _values(asked: Asked, results: Results) -> Any:
    return {
        kind: {profile: score_values(runs) for profile, runs in group.items()}
        for kind, group in _found(asked, results).items()
    }


ABLATION = Study("ablation", "Ablation: each remedy off in turn", _DRIVES.stages, _report, _values)
