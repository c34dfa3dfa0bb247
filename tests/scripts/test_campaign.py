"""Campaigns: the same results whatever the number of processes, kept as they come, resumable."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tolman.scripts.campaign import CampaignError, Job, Store, run_campaign

JOBS = [Job({"world": world, "seed": seed}) for world in ("env1", "env2") for seed in range(4)]


def work(values: Mapping[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng([values["seed"], len(values["world"])])
    return {"world": values["world"], "draw": rng.normal(), "nan": math.nan}


def fails_at_three(values: Mapping[str, Any]) -> dict[str, Any]:
    if values["seed"] == 3:
        raise RuntimeError("three")
    return work(values)


def test_results_are_in_the_order_of_the_jobs() -> None:
    results = run_campaign(JOBS, work)
    assert [result["world"] for result in results] == ["env1"] * 4 + ["env2"] * 4
    assert results[0]["nan"] is None


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

    assert run_campaign([Job({"seed": 1}), Job({"seed": 1})], count) == [{"seed": 1}] * 2
    assert seen == [1]


def test_what_was_finished_before_a_failure_is_not_run_again(tmp_path: Path) -> None:
    store = Store(tmp_path / "results.jsonl", "1")
    with pytest.raises(RuntimeError, match="three"):
        run_campaign(JOBS, fails_at_three, store=store)
    assert len(store.read()) == 3
    told: list[tuple[int, int]] = []
    results = run_campaign(JOBS, work, store=store, progress=lambda done, total: told.append((done, total)))
    assert told[0] == (3, 8)
    assert told[-1] == (8, 8)
    assert results == run_campaign(JOBS, work)


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
