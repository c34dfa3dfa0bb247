"""Study `unseen`: rooms and mazes drawn from seeds, mapped and navigated by profile `default`.

Nobody has looked at these worlds: their seeds count from the first one of the report, and development drew
other seeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .campaign import Job
from .mapping import mapping_job
from .random_rooms import KINDS
from .running import seeds
from .scores import SCORES, Runs, cell, closed, driven, failures, score_values
from .study import Asked, Groups, Results, Study
from .summary import markdown_table, share
from .variants import runs_of, trips
from .worlds import RANDOM

RUNS = 60
"""Pairs of a world and a seed, where not asked otherwise."""
WANTED = 0.95


def _maps(asked: Asked) -> list[Job]:
    return [
        mapping_job(f"{RANDOM} {seed}", side, seed, "default", local_maps=False)
        for seed, side in seeds(asked.first_seed, asked.runs or RUNS)
    ]


def _mappings(asked: Asked, results: Results) -> Groups:
    return {"unseen": _maps(asked)}


def _trips(asked: Asked, results: Results) -> Groups:
    return {"unseen": trips(_maps(asked), results, corrected=False)}


def _by_kind(asked: Asked, results: Results) -> dict[str, Runs]:
    found = {}
    for index, kind in enumerate(KINDS):
        jobs = [job for job in _maps(asked) if int(str(job.settings["seed"])) % len(KINDS) == index]
        found[kind] = runs_of(jobs, results)
    return found


def _done(runs: Sequence[Runs]) -> tuple[int, int]:
    """How many worlds were mapped, closed rightly and driven five times, and of how many."""
    good = sum(bool(trip["completed"]) for each in runs for trip in each.uncorrected)
    wrong = sum(run["loop_correct"] is False for each in runs for run in each.maps)
    return max(0, good - wrong), sum(len(each.maps) for each in runs)


def _report(asked: Asked, results: Results) -> str:
    found = _by_kind(asked, results)
    good, total = _done(list(found.values()))
    text = (
        "Rooms with blocks at their walls, the same turned by any angle, and mazes with thin walls, drawn "
        f"from seeds {asked.first_seed} on ({total} finished of {asked.runs or RUNS}): mapped without local "
        "maps, then five traversals from node to node, uncorrected by views. Cells: mean (worst)."
    )
    if total:
        low = share(good, total)[1]
        reached = "reached" if good >= WANTED * total else "**not** reached"
        text += (
            f" Mapped, closed rightly and driven to the end: **{good} of {total}** (at least {100 * low:.0f} "
            f"% with 95 % confidence); target {100 * WANTED:.0f} %, {reached}."
        )
    names = ("map error (cm)", "end, not corrected (cm)")
    scores = [score for score in SCORES if score.name in names]
    lines = [
        [
            kind,
            closed(runs.maps),
            *(cell(score.values(runs)) for score in scores),
            driven(runs.uncorrected),
            str(sum(int(run["collisions"]) for run in (*runs.maps, *runs.uncorrected))),
        ]
        for kind, runs in found.items()
    ]
    table = markdown_table(["rooms", "closed rightly", *names, "traversals completed", "collisions"], lines)
    lost = [line for kind, runs in found.items() for line in failures(kind, runs)]
    parts = [text, table]
    if lost:
        parts.append("Runs that did not do all they were to:\n\n" + "\n".join(lost))
    return "\n\n".join(parts)


def _values(asked: Asked, results: Results) -> Any:
    found = _by_kind(asked, results)
    good, total = _done(list(found.values()))
    return {
        "done": good,
        "of": total,
        "kinds": {kind: score_values(runs) for kind, runs in found.items()},
    }


UNSEEN = Study("unseen", "Worlds never seen", (_mappings, _trips), _report, _values)
