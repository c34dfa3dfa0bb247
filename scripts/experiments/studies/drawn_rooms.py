"""Studies `unseen` and `shapes`: rooms drawn from seeds, mapped and navigated by profile `default`.

Nobody has looked at these worlds: their seeds count from the first one of the report, and development drew
other seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..campaign.campaign import Job
from ..campaign.jobs import mapping_job, seeds
from ..results.scores import Runs, driven, runs_table, with_failures
from ..results.summary import share
from ..worlds.names import RANDOM
from ..worlds.random_rooms import KINDS
from ..worlds.shaped_rooms import SHAPES
from .study import Asked, MapAndDrive, Results, Study

RUNS, RUNS_A_SHAPE = 60, 20
"""Pairs of a world and a seed, where not asked otherwise; `RUNS_A_SHAPE` for each kind of shape."""
WANTED = 0.95
_MAP_ERROR = "map error (cm)"


def _mapping(kind: str, seed: int, side: str) -> Job:
    return mapping_job(f"{kind} {seed}", side, seed, "default", local_maps=False)


def _unseen(asked: Asked) -> dict[str, list[Job]]:
    jobs: dict[str, list[Job]] = {kind: [] for kind in KINDS}
    for seed, side in seeds(asked.first_seed, asked.runs or RUNS):
        jobs[KINDS[seed % len(KINDS)]].append(_mapping(RANDOM, seed, side))
    return jobs


def _shapes(asked: Asked) -> dict[str, list[Job]]:
    pairs = list(seeds(asked.first_seed, asked.runs or RUNS_A_SHAPE))
    return {kind: [_mapping(kind, seed, side) for seed, side in pairs] for kind in SHAPES}


def _done(runs: Sequence[Runs]) -> tuple[int, int]:
    """How many worlds were mapped, closed rightly and driven five times, and of how many."""
    good = sum(bool(trip["completed"]) for each in runs for trip in each.uncorrected)
    wrong = sum(run["loop_correct"] is False for each in runs for run in each.maps)
    return max(0, good - wrong), sum(len(each.maps) for each in runs)


def _drawn(
    name: str, title: str, text: str, maps: Callable[[Asked], dict[str, list[Job]]], bent: Sequence[str] = ()
) -> Study:
    """A study of drawn rooms. text: what is drawn. bent: kinds whose arcs are no straight lines."""
    drives = MapAndDrive(maps, lambda kind: (False,))

    def report(asked: Asked, results: Results) -> str:
        planned = sum(len(jobs) for jobs in maps(asked).values())
        drawn = f"{text}, drawn from seeds {asked.first_seed} on"
        return _report(drives.found(asked, results), drawn, planned, bent)

    def values(asked: Asked, results: Results) -> Any:
        good, total = _done(list(drives.found(asked, results).values()))
        return {"done": good, "of": total, "kinds": drives.values(asked, results)}

    return Study(name, title, drives.stages, report, values)


def _report(found: dict[str, Runs], text: str, planned: int, bent: Sequence[str]) -> str:
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
    columns = {
        "traversals completed": lambda kind, runs: driven(runs.uncorrected),
        "collisions": lambda kind, runs: str(runs.collisions),
    }
    left_out = [(kind, _MAP_ERROR) for kind in bent]
    table = runs_table("rooms", found, (_MAP_ERROR, "end, not corrected (cm)"), columns, left_out)
    return with_failures([text, table], found)


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
    ("round",),
)
