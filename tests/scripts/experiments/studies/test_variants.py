"""Study `variants`: which runs it is made of, and what it says of maps that were lost."""

from collections.abc import Callable
from typing import Any

from tolman.scripts.experiments.studies.study import Asked
from tolman.scripts.experiments.studies.variants import VARIANTS, worlds

ASKED = Asked(runs=2, environments=("env1",))
Make = Callable[..., Any]


def test_variants_map_every_world_from_both_sides_and_drive_each_map_twice(
    mapping: Make, jobs_of: Make
) -> None:
    jobs, _ = jobs_of(VARIANTS, ASKED, mapping())
    assert len(worlds(ASKED)) == 5
    assert sum(job.settings["kind"] == "map" for job in jobs) == 10
    assert sum(job.settings["kind"] == "traverse" for job in jobs) == 20
    assert {job.settings["side"] for job in jobs if job.settings["kind"] == "map"} == {"right", "left"}
    assert all(int(str(job.settings["seed"])) >= 4000 for job in jobs)


def test_imported_worlds_are_mapped_without_local_maps_and_driven_from_node_to_node(
    mapping: Make, jobs_of: Make
) -> None:
    asked = Asked(runs=2, environments=(), imported=("map.yaml x0.4",))
    jobs, _ = jobs_of(VARIANTS, asked, mapping())
    assert [job.settings["local_maps"] for job in jobs if job.settings["kind"] == "map"] == [False, False]
    assert [job.settings["corrected"] for job in jobs if job.settings["kind"] == "traverse"] == [False, False]


def test_a_map_that_did_not_get_round_is_not_driven_and_says_why(mapping: Make, jobs_of: Make) -> None:
    lost = mapping(finished=False, loop_correct=None, reason="3 rounds without recognizing a corner")
    jobs, results = jobs_of(VARIANTS, ASKED, lost)
    assert all(job.settings["kind"] == "map" for job in jobs)
    text = VARIANTS.report(ASKED, results)
    assert "env1 rotated, mapping, seed 4000: 3 rounds without recognizing a corner (missed)" in text
    assert "**no**: loop closing" in text
