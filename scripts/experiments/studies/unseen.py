"""Studies `unseen` and `shapes`: rooms drawn from seeds, mapped and navigated by profile `default`.

Nobody has looked at these worlds: their seeds count from the first one of the report, and development drew
other seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..campaign.campaign import Job
from ..campaign.running import seeds
from ..campaign.summary import markdown_table, share
from ..report.scores import SCORES, Runs, cell, closed, driven, failures, score_values
from ..runs.mapping import mapping_job
from ..runs.random_rooms import KINDS
from ..runs.shaped_rooms import SHAPES
from ..runs.worlds import RANDOM
from .study import Asked, Groups, Results, Study
from .variants import runs_of, trips

RUNS, RUNS_A_SHAPE = 60, 20
"""Pairs of a world and a seed, where not asked otherwise; `RUNS_A_SHAPE` for each kind of shape."""
WANTED = 0.95
Maps = Callable[[Asked], dict[str, list[Job]]]
"""Mappings by the kind of room."""


def _unseen(asked: Asked) -> dict[str, list[Job]]:
    jobs: dict[str, list[Job]] = {kind: [] for kind in KINDS}
    for seed, side in seeds(asked.first_seed, asked.runs or RUNS):
        job = mapping_job(f"{RANDOM} {seed}", side, seed, "default", local_maps=False)
        jobs[KINDS[seed % len(KINDS)]].append(job)
    return jobs


def _shapes(asked: Asked) -> dict[str, list[Job]]:
    return {
        kind: [
            mapping_job(f"{kind} {seed}", side, seed, "default", local_maps=False)
            for seed, side in seeds(asked.first_seed, asked.runs or RUNS_A_SHAPE)
        ]
        for kind in SHAPES
    }


def _done(runs: Sequence[Runs]) -> tuple[int, int]:
    """How many worlds were mapped, closed rightly and driven five times, and of how many."""
    good = sum(bool(trip["completed"]) for each in runs for trip in each.uncorrected)
    wrong = sum(run["loop_correct"] is False for each in runs for run in each.maps)
    return max(0, good - wrong), sum(len(each.maps) for each in runs)


def _drawn(name: str, title: str, text: str, maps: Maps, bent: frozenset[str] = frozenset()) -> Study:
    """A study of drawn rooms. text: what is drawn. bent: kinds whose arcs are no straight lines."""

    def mappings(asked: Asked, results: Results) -> Groups:
        return maps(asked)

    def driving(asked: Asked, results: Results) -> Groups:
        return {kind: trips(jobs, results, corrected=False) for kind, jobs in maps(asked).items()}

    def found(asked: Asked, results: Results) -> dict[str, Runs]:
        return {kind: runs_of(jobs, results) for kind, jobs in maps(asked).items()}

    def report(asked: Asked, results: Results) -> str:
        planned = sum(len(jobs) for jobs in maps(asked).values())
        return _report(
            found(asked, results), f"{text}, drawn from seeds {asked.first_seed} on", planned, bent
        )

    def values(asked: Asked, results: Results) -> Any:
        by_kind = found(asked, results)
        good, total = _done(list(by_kind.values()))
        kinds = {kind: score_values(runs) for kind, runs in by_kind.items()}
        return {"done": good, "of": total, "kinds": kinds}

    return Study(name, title, (mappings, driving), report, values)


def _report(found: dict[str, Runs], text: str, planned: int, bent: frozenset[str]) -> str:
    good, total = _done(list(found.values()))
    text += (
        f" ({total} finished of {planned}): mapped without local maps, then five traversals from node to "
        "node, uncorrected by views. Cells: mean (worst)."
    )
    if bent:
        text += (
            " Along a round wall an arc is longer than the straight line between its nodes: no map error "
            "is given there."
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
            *(
                "" if kind in bent and score.name == names[0] else cell(score.values(runs))
                for score in scores
            ),
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


UNSEEN = _drawn(
    "unseen",
    "Worlds never seen",
    "Rooms with blocks at their walls, the same turned by any angle, and mazes with thin walls",
    _unseen,
)
SHAPED = _drawn(
    "shapes",
    "Walls at any angle, round walls, narrow passages",
    "Rooms of five to nine walls at any angle, rooms with round pillars in their walls (6 to 30 cm in "
    "radius), and rooms in two parts joined by a passage 10 to 14 cm wide",
    _shapes,
    frozenset({"round"}),
)
