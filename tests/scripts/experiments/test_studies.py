"""Studies beyond the tables: which runs they are made of, and what is said of runs of known figures."""

import json
from pathlib import Path
from typing import Any

import pytest
from tolman.scripts.cli.output import plain
from tolman.scripts.cli.program import execute
from tolman.scripts.experiments.campaign.campaign import Job, Result
from tolman.scripts.experiments.campaign.version import code_version, imported_scripts
from tolman.scripts.experiments.report.page import STUDIES
from tolman.scripts.experiments.report.scores import SCORES, Runs, closing, kept
from tolman.scripts.experiments.studies.ablation import ABLATION, OF_LOCAL_MAPS, OF_THE_BOUNDARY
from tolman.scripts.experiments.studies.study import Asked, Study, run_study
from tolman.scripts.experiments.studies.variants import VARIANTS, worlds
from tolman.scripts.session.profiles import REMEDIES, find_profile

ASKED = Asked(runs=2, environments=("env1",))


def mapping(**values: Any) -> Result:
    result = {
        "finished": True,
        "loop_correct": True,
        "reason": "loop closed",
        "position_error_m": 0.001,
        "explored": [[0.001, 0.01]],
        "collisions": 0,
        "sim_time_s": 100.0,
        "seed": 4000,
    }
    return {**result, **values}


def trip(**values: Any) -> Result:
    result = {
        "completed": True,
        "end_error_m": 0.001,
        "headings": [0.01],
        "collisions": 0,
        "lost": "",
        "sim_time_s": 50.0,
    }
    return {**result, **values}


def jobs_of(study: Study, asked: Asked, mapped: Result) -> tuple[list[Job], dict[str, Result]]:
    """All jobs of a study whose mappings all come out as `mapped`, and their results."""
    jobs: list[Job] = []
    results: dict[str, Result] = {}
    for stage in study.stages:
        for group in stage(asked, results).values():
            jobs += group
            results |= {job.key: mapped if job.settings["kind"] == "map" else trip() for job in group}
    return jobs, results


def test_variants_map_every_world_from_both_sides_and_drive_each_map_twice() -> None:
    jobs, _ = jobs_of(VARIANTS, ASKED, mapping())
    assert len(worlds(ASKED)) == 5
    assert sum(job.settings["kind"] == "map" for job in jobs) == 10
    assert sum(job.settings["kind"] == "traverse" for job in jobs) == 20
    assert {job.settings["side"] for job in jobs if job.settings["kind"] == "map"} == {"right", "left"}
    assert all(int(str(job.settings["seed"])) >= 4000 for job in jobs)


def test_imported_worlds_are_mapped_without_local_maps_and_driven_from_node_to_node() -> None:
    asked = Asked(runs=2, environments=(), imported=("map.yaml x0.4",))
    jobs, _ = jobs_of(VARIANTS, asked, mapping())
    assert [job.settings["local_maps"] for job in jobs if job.settings["kind"] == "map"] == [False, False]
    assert [job.settings["corrected"] for job in jobs if job.settings["kind"] == "traverse"] == [False, False]


def test_a_map_that_did_not_get_round_is_not_driven_and_says_why() -> None:
    lost = mapping(finished=False, loop_correct=None, reason="3 rounds without recognizing a corner")
    jobs, results = jobs_of(VARIANTS, ASKED, lost)
    assert all(job.settings["kind"] == "map" for job in jobs)
    text = VARIANTS.report(ASKED, results)
    assert "env1 rotated, mapping, seed 4000: 3 rounds without recognizing a corner (missed)" in text
    assert "**no**: loop closing" in text


def test_a_variant_keeps_what_gives_up_a_third_of_the_margin_and_no_more() -> None:
    """Map error in env1: target 1 cm, published 7: 3 cm are allowed."""
    error = next(score for score in SCORES if score.name == "map error (cm)")
    assert error.limit(0) == pytest.approx(3.0)
    assert kept(Runs(maps=[mapping(position_error_m=0.029)]), 0) == []
    assert kept(Runs(maps=[mapping(position_error_m=0.031)]), 0) == ["map error (cm)"]
    assert kept(Runs(maps=[mapping()], corrected=[trip(completed=False)]), 0) == ["runs lost"]


def test_saying_ambiguous_is_neither_right_nor_wrong() -> None:
    assert closing(mapping(loop_correct=None, reason="ambiguous: four equal corners")) == "ambiguous"
    assert closing(mapping(loop_correct=False)) == "wrong"
    assert closing(mapping(loop_correct=None, reason="max time")) == "missed"


def test_an_ablation_runs_the_whole_profile_and_each_without_one_remedy() -> None:
    jobs, results = jobs_of(ABLATION, ASKED, mapping())
    profiles = {str(job.settings["profile"]) for job in jobs if job.settings["kind"] == "map"}
    assert profiles == {"default", *(f"default without {r}" for r in {*OF_LOCAL_MAPS, *OF_THE_BOUNDARY})}
    assert {*OF_LOCAL_MAPS, *OF_THE_BOUNDARY} == set(REMEDIES)
    assert all(find_profile(profile) for profile in profiles)
    text = ABLATION.report(ASKED, results)
    assert "| without compass" in text
    assert "| without recognized corners" in text


def test_beyond_drops_robots_on_maps_of_both_sides_and_changes_worlds() -> None:
    jobs, _ = jobs_of(STUDIES["beyond"], Asked(runs=8, environments=("env1",)), mapping())
    kinds = [str(job.settings["kind"]) for job in jobs]
    # env1 and two rooms that repeat themselves, dropped in two ways
    assert kinds.count("unknown-start") == 3 * 2 * 8
    assert kinds.count("changed-world") == 4 * 2
    assert {job.settings["map side"] for job in jobs if "map side" in job.settings} == {"right", "left"}
    assert sum("islands" in job.settings for job in jobs) == 1


def test_shapes_map_and_drive_as_many_rooms_of_each_kind() -> None:
    jobs, results = jobs_of(STUDIES["shapes"], Asked(runs=4), mapping())
    worlds = [str(job.settings["world"]) for job in jobs if job.settings["kind"] == "map"]
    assert len(worlds) == len(set(worlds)) == 12
    text = STUDIES["shapes"].report(Asked(runs=4), results)
    assert "Mapped, closed rightly and driven to the end: **12 of 12**" in text
    assert [text.count(f"| {kind} ") for kind in ("slanted", "round", "narrow")] == [1, 1, 1]


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_every_study_reports_also_where_nothing_has_run(name: str) -> None:
    study = STUDIES[name]
    assert "none" in study.report(ASKED, {})
    assert json.dumps(plain(study.values(ASKED, {})), allow_nan=False)


def test_a_later_stage_sees_the_results_of_the_earlier(tmp_path: Any) -> None:
    seen: list[int] = []

    def stage(asked: Asked, results: Any) -> dict[str, list[Job]]:
        seen.append(len(results))
        return {}

    study = Study("s", "S", (stage, stage), lambda asked, results: "", lambda asked, results: {})
    assert run_study(study, ASKED, tmp_path) == {}
    assert seen == [0, 0]


def test_the_layout_of_the_report_is_no_part_of_what_results_depend_on() -> None:
    for script in ("experiments.runs.mapping", "experiments.runs.traversal"):
        parts = imported_scripts(script)
        assert {
            "session.mapping_run",
            "session.profiles",
            "session.assembly",
            "session.truth",
            "experiments.runs.probes",
        } <= parts
        assert not parts & {f"experiments.{name}" for name in ("report", "tables", "figures", "campaign")}
    assert "experiments.runs.traversal" not in imported_scripts("experiments.runs.mapping")
    assert code_version() != code_version("experiments.runs.traversal")


def test_a_study_of_profile_thesis_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["experiment", "ablation", "--profile", "thesis", "--work", str(tmp_path / "work")]
    assert execute(arguments) == 2
    assert "studies are of profile default" in capsys.readouterr().err
