"""Plans: which tables and kinds of runs are asked for, and how many runs."""

import pytest
from tolman.scripts.experiments.campaign.campaign import CampaignError
from tolman.scripts.experiments.campaign.kinds import CORRECTED, GLOBAL, LOCAL, NEEDS, REFERENCE
from tolman.scripts.experiments.campaign.plan import Plan, plan_for


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
    with pytest.raises(CampaignError, match=r"did you mean 'table-4\.1"):
        plan_for(["table-4.11"], None, None)


def test_only_the_kinds_that_a_table_needs_are_run() -> None:
    assert plan_for(["table-4.3"], None, None).kinds == {GLOBAL}
    assert plan_for(["table-4.16"], None, None).kinds == {LOCAL, CORRECTED}


def test_a_plan_without_runs_needs_no_environments_twice() -> None:
    assert Plan(("table-4.2", "table-4.3")).kinds == {"reference", GLOBAL}


def test_profile_thesis_can_have_fewer_runs() -> None:
    plan = Plan(("table-4.2", "table-4.5"), 20, 50, thesis_runs=6, thesis_global_runs=10)
    assert [plan.runs_of(kind, "thesis") for kind in (LOCAL, GLOBAL, REFERENCE)] == [6, 10, 2]
    assert [plan.runs_of(kind, "default") for kind in (LOCAL, GLOBAL, REFERENCE)] == [20, 50, 2]
