"""Studies of drawn rooms: which runs they are made of, and their verdict."""

from collections.abc import Callable
from typing import Any

from tolman.scripts.experiments.studies.drawn_rooms import SHAPED
from tolman.scripts.experiments.studies.study import Asked

Make = Callable[..., Any]


def test_shapes_map_and_drive_as_many_rooms_of_each_kind(mapping: Make, jobs_of: Make) -> None:
    jobs, results = jobs_of(SHAPED, Asked(runs=4), mapping())
    worlds = [str(job.settings["world"]) for job in jobs if job.settings["kind"] == "map"]
    assert len(worlds) == len(set(worlds)) == 12
    text = SHAPED.report(Asked(runs=4), results)
    assert "Mapped, closed rightly and driven to the end: **12 of 12**" in text
    assert [text.count(f"| {kind} ") for kind in ("slanted", "round", "narrow")] == [1, 1, 1]
