"""Campaigns: the same results whatever the number of processes, kept as they come, resumable."""

import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tolman.scripts.experiments.campaign.campaign import CampaignError, Job, Progress, Store, run_campaign

JOBS = [Job({"world": world, "seed": seed}) for world in ("env1", "env2") for seed in range(4)]


def work(values: Mapping[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng([values["seed"], len(values["world"])])
    return {"world": values["world"], "draw": rng.normal(), "nan": math.nan}


def fails_at_three(values: Mapping[str, Any]) -> dict[str, Any]:
    if values["seed"] == 3:
        raise RuntimeError("three")
    return work(values)


def test_results_are_by_job_in_the_order_of_the_jobs() -> None:
    results = run_campaign(JOBS, work)
    assert list(results) == [job.key for job in JOBS]
    assert [result["world"] for result in results.values()] == ["env1"] * 4 + ["env2"] * 4
    assert results[JOBS[0].key]["nan"] is None


@pytest.mark.slow
def test_the_number_of_processes_changes_nothing() -> None:
    def draw(values: Mapping[str, Any]) -> dict[str, Any]:  # local, so that it is sent by value
        return {"draw": np.random.default_rng(values["seed"]).normal()}

    assert run_campaign(JOBS, draw, processes=2) == run_campaign(JOBS, draw)


def test_equal_settings_are_run_once() -> None:
    seen = []

    def count(values: Mapping[str, Any]) -> dict[str, Any]:
        seen.append(values["seed"])
        return {"seed": values["seed"]}

    assert run_campaign([Job({"seed": 1}), Job({"seed": 1})], count) == {Job({"seed": 1}).key: {"seed": 1}}
    assert seen == [1]


def test_what_was_finished_before_a_failure_is_not_run_again(tmp_path: Path) -> None:
    store = Store(tmp_path / "results.jsonl", "1")
    with pytest.raises(RuntimeError, match="three"):
        run_campaign(JOBS, fails_at_three, store=store)
    assert len(store.read()) == 3
    told: list[Progress] = []
    results = run_campaign(JOBS, work, store=store, progress=told.append)
    assert told[0] == Progress(3, 8, None)
    assert (told[-1].done, told[-1].total, told[-1].seconds_left) == (8, 8, 0.0)
    assert results == run_campaign(JOBS, work)


def test_after_its_time_no_job_is_begun_and_the_others_are_kept(tmp_path: Path) -> None:
    store = Store(tmp_path / "results.jsonl", "1")
    run_campaign(JOBS[:2], work, store=store)
    found = run_campaign(JOBS, work, store=store, until=time.monotonic() - 1.0)
    assert list(found) == [job.key for job in JOBS[:2]]


def test_the_time_left_is_guessed_from_the_cost_of_the_rest() -> None:
    """Jobs that cost as much as all before them: the rest takes about as long again."""
    told: list[Progress] = []
    costs = {job.key: float(2**k) for k, job in enumerate(JOBS)}

    def sleep(values: Mapping[str, Any]) -> dict[str, Any]:
        time.sleep(0.02)
        return work(values)

    run_campaign(JOBS, sleep, progress=told.append, cost=lambda job: costs[job.key])
    left = [one.seconds_left for one in told[1:-1]]
    assert all(one is not None and one > 0.0 for one in left)


def test_each_kind_of_job_has_a_version_of_its_own(tmp_path: Path) -> None:
    versions = {"env1": "1", "env2": "1"}
    run_campaign(JOBS, work, store=Store(tmp_path / "r", lambda job: versions[str(job["world"])]))
    versions["env2"] = "2"
    found = Store(tmp_path / "r", lambda job: versions[str(job["world"])]).read()
    assert {result["world"] for result in found.values()} == {"env1"}


def test_a_run_that_fails_does_not_take_the_others_with_it_where_somebody_is_told(tmp_path: Path) -> None:
    told: list[tuple[Job, str]] = []
    store = Store(tmp_path / "r", "1")
    results = run_campaign(
        JOBS, fails_at_three, store=store, failed=lambda job, error: told.append((job, error))
    )
    assert [job.settings["seed"] for job, _ in told] == [3, 3]
    assert told[0][1].startswith("RuntimeError at test_campaign.py:")
    assert len(results) == len(store.read()) == 6


def test_results_of_another_version_are_not_taken_up(tmp_path: Path) -> None:
    run_campaign(JOBS[:2], work, store=Store(tmp_path / "r", "1"))
    assert Store(tmp_path / "r", "2").read() == {}


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@given(cut=st.integers(1, 400))
def test_a_line_cut_off_by_a_kill_is_run_again(tmp_path: Path, cut: int) -> None:
    store = Store(tmp_path / "results.jsonl", "1")
    store.path.unlink(missing_ok=True)
    whole = run_campaign(JOBS, work, store=store)
    data = store.path.read_bytes()
    store.path.write_bytes(data[: len(data) - cut])
    assert run_campaign(JOBS, work, store=store) == whole
    assert len(store.read()) == len(JOBS)


def test_a_file_that_is_no_store_is_refused(tmp_path: Path) -> None:
    (tmp_path / "r").write_text("hello\nworld\n")
    with pytest.raises(CampaignError, match="line 1: not a result"):
        run_campaign(JOBS, work, store=Store(tmp_path / "r", "1"))
