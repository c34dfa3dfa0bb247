"""Reports of experiments: what is counted, compared and said of runs whose figures are known."""

import json
import math
import re
from typing import Any

import pytest
from tolman.scripts.cli.output import plain
from tolman.scripts.experiments.campaign.campaign import Result
from tolman.scripts.experiments.campaign.plan import CORRECTED, GLOBAL, LOCAL, REFERENCE, Outcome, Plan
from tolman.scripts.experiments.report.report import report_text, report_values
from tolman.scripts.experiments.report.rows import Row, rows_of
from tolman.scripts.experiments.report.tables import TABLES
from tolman.scripts.experiments.report.targets import Target
from tolman.scripts.experiments.runs.mapping import mapping_job
from tolman.scripts.experiments.runs.traversal import _slope

WORLD = "env1"


def mapping(error: float, **values: Any) -> Result:
    result = {
        "position_error_m": error,
        "largest_arc_error_m": 0.01,
        "loop_distance_m": 4.6 + error,
        "true_loop_distance_m": 4.6,
        "path_integration_error_m": 0.6,
        "nodes": 10,
        "local_maps": 10,
        "loop_correct": True,
        "finished": True,
        "sim_time_s": 100.0,
        "explored": [[0.01, math.radians(10.0)]],
        "docked": [[0.001, 0.0]],
        "closing": {"T1": "missed", "T2": "right", "T3": "wrong"},
        "trained": [],
        "estimates": {},
    }
    return {**result, **values}


def outcome(kind: str, profile: str, results: list[Result], seeds: range | None = None) -> Outcome:
    jobs = [
        mapping_job(WORLD, ("right", "left")[seed % 2], seed, profile, local_maps=kind == LOCAL)
        for seed in seeds or range(len(results))
    ]
    return Outcome({(kind, WORLD, profile): results}, {(kind, WORLD, profile): jobs})


def rows(number: str, found: Outcome, profile: str) -> dict[str, Row]:
    table = next(table for table in TABLES if table.number == number)
    plan = Plan((f"table-{number}",), environments=(WORLD,), profiles=(profile,))
    return {row.figure: row for row in rows_of(table, plan, found)}


def test_a_target_is_reached_when_mean_and_worst_keep_it() -> None:
    good = rows("4.2", outcome(GLOBAL, "default", [mapping(0.005), mapping(0.012)]), "default")
    assert good["position error"].reached
    worst = rows("4.2", outcome(GLOBAL, "default", [mapping(0.0)] * 9 + [mapping(0.05)]), "default")
    assert not worst["position error"].reached


def test_a_mean_outside_the_published_range_counts_as_not_reproduced() -> None:
    inside = rows("4.2", outcome(GLOBAL, "thesis", [mapping(0.08)]), "thesis")
    outside = rows("4.2", outcome(GLOBAL, "thesis", [mapping(0.01)]), "thesis")
    assert inside["position error"].reproduced
    assert outside["position error"].reproduced is False


def test_a_run_that_did_not_get_round_is_counted_and_not_averaged() -> None:
    found = rows("4.2", outcome(GLOBAL, "default", [mapping(0.0), mapping(9.0, finished=False)]), "default")
    assert found["position error"].measured["default"].summary is not None
    assert found["position error"].measured["default"].summary.greatest == 0.0
    assert found["got round"].measured["default"].count == 1
    assert found["got round"].reached is False


def test_the_distance_is_compared_with_the_one_noise_free_run_along_the_right_wall() -> None:
    found = outcome(GLOBAL, "default", [mapping(0.0, loop_distance_m=4.5), mapping(0.0, loop_distance_m=4.7)])
    free = outcome(
        REFERENCE, "default", [mapping(0.0, loop_distance_m=4.6), mapping(0.0, loop_distance_m=9.9)]
    )
    both = Outcome({**found.results, **free.results}, {**found.jobs, **free.jobs})
    measured = rows("4.2", both, "default")["distance against the noise-free run"].measured["default"]
    assert measured.summary is not None
    assert measured.summary.mean == pytest.approx(10.0)


def test_loop_closing_is_counted_at_each_threshold() -> None:
    found = rows("4.18", outcome(LOCAL, "thesis", [mapping(0.0), mapping(0.0)]), "thesis")
    assert found["T2, right"].measured["thesis"].count == 2
    assert found["T1, right"].measured["thesis"].count == 0
    assert found["T3, wrong"].measured["thesis"].count == 2


def test_errors_of_all_local_maps_are_put_together_in_cm_and_degrees() -> None:
    found = rows("4.5", outcome(LOCAL, "thesis", [mapping(0.0)] * 3), "thesis")
    summary = found["heading error after exploring"].measured["thesis"].summary
    assert summary is not None
    assert summary.count == 3
    assert summary.mean == pytest.approx(10.0)
    assert found["position error after exploring"].measured["thesis"].summary is not None


def test_runs_lost_in_traversals_count_against_the_target() -> None:
    results = [{"completed": done, "end_error_m": 0.005, "sim_time_s": 1.0} for done in (True, False)]
    table = rows("4.14", Outcome({(CORRECTED, WORLD, "default"): results}), "default")
    assert table["completed"].measured["default"].count == 1
    assert table["completed"].reached is False
    ends = rows("4.15", Outcome({(CORRECTED, WORLD, "default"): results}), "default")
    measured = ends["position error at the end"].measured["default"].summary
    assert measured is not None
    assert measured.count == 1


def test_the_report_names_the_targets_that_were_missed_and_the_seeds() -> None:
    plan = Plan(("table-4.2",), 2, 2, 2000, (WORLD,), ("default",))
    text = report_text(plan, outcome(GLOBAL, "default", [mapping(0.0), mapping(0.3)]), {"map": "1"})
    assert "- 4.2 position error, env1: mean 15.00, worst 30.00; target mean ≤ 1, worst ≤ 4" in text
    assert "Seeds 2000 to 2001" in text
    assert "Version of the code by kind of run: map 1." in text


def test_the_report_counts_targets_and_lists_lost_runs_with_their_reasons() -> None:
    plan = Plan(("table-4.2",), 2, 2, 2000, (WORLD,), ("default",))
    lost = mapping(9.0, finished=False, reason="3 rounds without recognizing a corner")
    text = report_text(
        plan, outcome(GLOBAL, "default", [mapping(0.0), lost]), {"map": "1"}, notes="It was dark."
    )
    assert "reaches **2 of 3** targets" in text
    assert "- mapping, no local maps, env1, seed 1: 3 rounds without recognizing a corner" in text
    assert "It was dark." in text


def test_the_report_of_an_unfinished_campaign_says_how_much_of_it_there_is() -> None:
    plan = Plan(("table-4.2",), 20, 50, 2000, (WORLD,), ("default",))
    text = report_text(plan, outcome(GLOBAL, "default", [mapping(0.0)] * 3), {"map": "1"})
    assert re.search(r"mapping, no local maps *\| *default *\| *3 of 50 *\| *100 *\|", text)


def test_profile_thesis_can_have_fewer_runs() -> None:
    plan = Plan(("table-4.2", "table-4.5"), 20, 50, thesis_runs=6, thesis_global_runs=10)
    assert [plan.runs_of(kind, "thesis") for kind in (LOCAL, GLOBAL, REFERENCE)] == [6, 10, 2]
    assert [plan.runs_of(kind, "default") for kind in (LOCAL, GLOBAL, REFERENCE)] == [20, 50, 2]


def test_the_report_can_be_written_as_json_even_where_nothing_was_run() -> None:
    plan = Plan(("table-4.2", "table-4.10", "table-4.16"), 2, 2, 2000, (WORLD,))
    values = plain(report_values(plan, Outcome(), {"map": "1"}))
    assert json.loads(json.dumps(values, allow_nan=False))["tables"]["4.10"] == []
    assert "none" in report_text(plan, Outcome(), {"map": "1"})


def test_a_target_reads_as_its_limits() -> None:
    assert Target((1.0, 1.5, 1.5), (4.0, 4.0, 4.0)).describe(1) == "mean ≤ 1.5, worst ≤ 4"


def test_the_growth_of_an_error_is_its_slope() -> None:
    assert _slope([0.0, 0.01, 0.02, 0.03, 0.04]) == pytest.approx(0.01)
    assert _slope([0.1]) is None
