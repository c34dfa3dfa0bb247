"""Running: what makes a run is named, and loaded where the run is made."""

import importlib
import subprocess
import sys

import pytest
from tolman.scripts.experiments.campaign.campaign import Job
from tolman.scripts.experiments.campaign.jobs import mapping_job
from tolman.scripts.experiments.campaign.running import RUNS, expected_cost, paced, version_of


@pytest.mark.parametrize("kind", RUNS)
def test_every_kind_of_run_names_a_function_that_there_is(kind: str) -> None:
    module, _, function = RUNS[kind].partition(":")
    assert callable(getattr(importlib.import_module(f"tolman.scripts.experiments.runs.{module}"), function))


def test_a_page_of_results_is_made_without_what_makes_the_runs() -> None:
    code = "import sys, tolman.scripts.experiments.page; print(*sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    loaded = told.split()
    assert "tolman.scripts.experiments.campaign.running" in loaded
    assert not [name for name in loaded if name.startswith("tolman.scripts.experiments.runs")]
    assert "dartpy" not in loaded


def test_results_of_a_kind_that_there_is_no_more_have_no_version() -> None:
    assert version_of({"kind": "of before"}) == ""


def test_groups_are_run_at_the_same_pace_and_the_longest_of_a_round_first() -> None:
    short = [mapping_job("env1", "right", seed, "default", local_maps=False) for seed in range(2)]
    long = [mapping_job("env3", "right", seed, "default", local_maps=True) for seed in range(4)]
    order = paced([short, long])
    assert order == [long[0], short[0], long[1], long[2], short[1], long[3]]
    assert expected_cost(long[0]) > expected_cost(short[0]) > 0.0
    assert paced([]) == list[Job]()
