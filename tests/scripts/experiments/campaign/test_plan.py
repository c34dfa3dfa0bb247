"""Experiments: what is run for which table, and on which map."""

from pathlib import Path

import pytest
from tolman.scripts.experiments.campaign.campaign import Job
from tolman.scripts.experiments.campaign.plan import (
    CORRECTED,
    GLOBAL,
    LOCAL,
    NEEDS,
    Outcome,
    Plan,
    average_maps,
    plan_for,
)
from tolman.scripts.experiments.runs.mapping import map_path, mapping_job
from tolman.scripts.experiments.runs.traversal import map_job_of, traversal_job
from tolman.scripts.session.requests import SessionError


def test_all_is_every_table_in_order_and_once() -> None:
    plan = plan_for(["table-4.3", "all", "all"], None, None)
    assert plan.tables == tuple(NEEDS)
    assert (plan.runs, plan.global_runs, plan.first_seed) == (20, 50, 4000)


def test_smoke_is_one_run_in_one_environment() -> None:
    plan = plan_for(["smoke"], None, None)
    assert (plan.runs, plan.global_runs, plan.environments) == (1, 1, ("env1",))


def test_runs_count_for_all_kinds_unless_the_global_ones_are_named() -> None:
    assert plan_for(["all"], 3, None).global_runs == 3
    assert plan_for(["all"], 3, 7).global_runs == 7


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(SessionError, match=r"did you mean table-4\.1"):
        plan_for(["table-4.11"], None, None)


def test_only_the_kinds_that_a_table_needs_are_run() -> None:
    assert plan_for(["table-4.3"], None, None).kinds == {GLOBAL}
    assert plan_for(["table-4.16"], None, None).kinds == {LOCAL, CORRECTED}


def test_a_traversal_names_the_mapping_whose_map_it_drives() -> None:
    job = mapping_job("env2", "left", 7, "thesis", local_maps=True)
    assert map_job_of(traversal_job(job, 8, corrected=True).settings).key == job.key


def test_maps_of_different_runs_do_not_share_a_file() -> None:
    one = mapping_job("env1", "right", 1, "default", local_maps=True)
    other = mapping_job("env1", "right", 1, "default", local_maps=False)
    assert map_path(Path("w"), one) != map_path(Path("w"), other)


def _outcome(errors: dict[int, float], finished: dict[int, bool] | None = None) -> Outcome:
    key = (LOCAL, "env1", "default")
    jobs: list[Job] = []
    results = []
    for seed, error in errors.items():
        jobs.append(
            mapping_job("env1", "right" if seed % 2 == 0 else "left", seed, "default", local_maps=True)
        )
        results.append({"position_error_m": error, "finished": (finished or {}).get(seed, True)})
    return Outcome({key: results}, {key: jobs})


def test_the_average_map_is_the_one_nearest_to_its_sides_mean() -> None:
    maps = average_maps(_outcome({0: 0.01, 2: 0.02, 4: 0.06, 1: 0.5}), "env1", "default")
    assert maps["right"].settings["seed"] == 2
    assert maps["left"].settings["seed"] == 1


def test_a_map_that_did_not_get_round_is_never_driven() -> None:
    maps = average_maps(_outcome({0: 0.01, 2: 0.02}, {0: False, 2: False}), "env1", "default")
    assert maps == {}


def test_a_plan_without_runs_needs_no_environments_twice() -> None:
    assert Plan(("table-4.2", "table-4.3")).kinds == {"reference", GLOBAL}
