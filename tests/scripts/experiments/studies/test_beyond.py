"""Study `beyond`: which runs it is made of."""

from collections.abc import Callable
from typing import Any

from tolman.scripts.experiments.studies.beyond import BEYOND
from tolman.scripts.experiments.studies.study import Asked

Make = Callable[..., Any]


def test_beyond_drops_robots_on_maps_of_both_sides_and_changes_worlds(mapping: Make, jobs_of: Make) -> None:
    jobs, _ = jobs_of(BEYOND, Asked(runs=8, environments=("env1",)), mapping())
    kinds = [str(job.settings["kind"]) for job in jobs]
    # env1 and two rooms that repeat themselves, dropped in two ways
    assert kinds.count("unknown-start") == 3 * 2 * 8
    assert kinds.count("changed-world") == 4 * 2
    assert {job.settings["map side"] for job in jobs if "map side" in job.settings} == {"right", "left"}
    assert sum("islands" in job.settings for job in jobs) == 1
