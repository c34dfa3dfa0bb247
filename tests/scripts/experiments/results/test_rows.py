"""Rows of the tables: what is counted, compared and said of runs whose figures are known."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from tolman.scripts.experiments.campaign.kinds import CORRECTED, GLOBAL, LOCAL, REFERENCE
from tolman.scripts.experiments.campaign.plan import Outcome, Plan
from tolman.scripts.experiments.results.rows import Row, rows_of
from tolman.scripts.experiments.results.tables import TABLES

WORLD = "env1"
Make = Callable[..., Any]


def rows(number: str, found: Outcome, profile: str) -> dict[str, Row]:
    table = next(table for table in TABLES if table.number == number)
    plan = Plan((f"table-{number}",), environments=(WORLD,), profiles=(profile,))
    return {row.figure: row for row in rows_of(table, plan, found)}


def test_a_target_is_reached_when_mean_and_worst_keep_it(mapping: Make, outcome: Make) -> None:
    good = rows("4.2", outcome(GLOBAL, "default", [mapping(0.005), mapping(0.012)]), "default")
    assert good["position error"].reached
    worst = rows("4.2", outcome(GLOBAL, "default", [mapping(0.0)] * 9 + [mapping(0.05)]), "default")
    assert not worst["position error"].reached


def test_a_mean_outside_the_published_range_counts_as_not_reproduced(mapping: Make, outcome: Make) -> None:
    inside = rows("4.2", outcome(GLOBAL, "thesis", [mapping(0.08)]), "thesis")
    outside = rows("4.2", outcome(GLOBAL, "thesis", [mapping(0.01)]), "thesis")
    assert inside["position error"].reproduced
    assert outside["position error"].reproduced is False


def test_a_run_that_did_not_get_round_is_counted_and_not_averaged(mapping: Make, outcome: Make) -> None:
    found = rows("4.2", outcome(GLOBAL, "default", [mapping(0.0), mapping(9.0, finished=False)]), "default")
    assert found["position error"].measured["default"].summary is not None
    assert found["position error"].measured["default"].summary.greatest == 0.0
    assert found["got round"].measured["default"].count == 1
    assert found["got round"].reached is False


def test_the_distance_is_compared_with_the_one_noise_free_run_along_the_right_wall(
    mapping: Make, outcome: Make
) -> None:
    found = outcome(GLOBAL, "default", [mapping(0.0, loop_distance_m=4.5), mapping(0.0, loop_distance_m=4.7)])
    free = outcome(
        REFERENCE, "default", [mapping(0.0, loop_distance_m=4.6), mapping(0.0, loop_distance_m=9.9)]
    )
    both = Outcome({**found.results, **free.results}, {**found.jobs, **free.jobs})
    measured = rows("4.2", both, "default")["distance against the noise-free run"].measured["default"]
    assert measured.summary is not None
    assert measured.summary.mean == pytest.approx(10.0)


def test_loop_closing_is_counted_at_each_threshold(mapping: Make, outcome: Make) -> None:
    found = rows("4.18", outcome(LOCAL, "thesis", [mapping(0.0), mapping(0.0)]), "thesis")
    assert found["T2, right"].measured["thesis"].count == 2
    assert found["T1, right"].measured["thesis"].count == 0
    assert found["T3, wrong"].measured["thesis"].count == 2


def test_errors_of_all_local_maps_are_put_together_in_cm_and_degrees(mapping: Make, outcome: Make) -> None:
    found = rows(
        "4.5", outcome(LOCAL, "thesis", [mapping(explored=[[0.01, math.radians(10.0)]])] * 3), "thesis"
    )
    summary = found["heading error after exploring"].measured["thesis"].summary
    assert summary is not None
    assert summary.count == 3
    assert summary.mean == pytest.approx(10.0)
    assert found["position error after exploring"].measured["thesis"].summary is not None


def test_runs_lost_in_traversals_count_against_the_target(trip: Make, outcome: Make) -> None:
    results = [trip(completed=done) for done in (True, False)]
    table = rows("4.14", outcome(CORRECTED, "default", results), "default")
    assert table["completed"].measured["default"].count == 1
    assert table["completed"].reached is False
    ends = rows("4.15", outcome(CORRECTED, "default", results), "default")
    measured = ends["position error at the end"].measured["default"].summary
    assert measured is not None
    assert measured.count == 1


def test_an_environment_is_held_against_its_own_published_figures(outcome: Make) -> None:
    """Also where the others are left out."""
    table = next(table for table in TABLES if table.number == "4.2")
    plan = Plan(("table-4.2",), environments=("env3",), profiles=("default",))
    row = rows_of(table, plan, Outcome())[0]
    assert (row.environment, row.published) == ("env3", (10, 6, 18))
    assert row.target == "mean ≤ 1.5, worst ≤ 4"
