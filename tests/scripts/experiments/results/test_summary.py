"""Summaries of runs: inside their bounds, repeatable, honest about runs that were lost."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.scripts.experiments.results.summary import markdown_table, share, summarize


@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=50))
def test_a_summary_is_in_order(values: list[float]) -> None:
    summary = summarize(values)
    assert summary is not None
    slack = 1e-9 * (1 + summary.greatest)
    assert summary.count == len(values)
    assert summary.least - slack <= summary.low <= summary.high <= summary.greatest + slack
    assert summary.least - slack <= summary.mean <= summary.greatest + slack
    assert summarize(values) == summary


def test_the_interval_of_a_mean_narrows_with_more_runs() -> None:
    few, many = summarize([1.0, 2.0, 3.0] * 3), summarize([1.0, 2.0, 3.0] * 30)
    assert few is not None
    assert many is not None
    assert many.high - many.low < 0.5 * (few.high - few.low)


def test_no_runs_have_no_summary_and_lost_runs_are_not_averaged() -> None:
    assert summarize([]) is None
    with pytest.raises(ValueError, match="lost"):
        summarize([1.0, math.nan])


@given(st.integers(1, 1000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_a_share_lies_in_its_interval(counts: tuple[int, int]) -> None:
    p, low, high = share(*counts)
    assert 0.0 <= low <= p + 1e-12
    assert p - 1e-12 <= high <= 1.0


def test_a_share_is_as_wilson_has_it() -> None:
    assert share(19, 20) == pytest.approx((0.95, 0.7639, 0.9911), abs=1e-4)
    with pytest.raises(ValueError, match="no share"):
        share(3, 2)


def test_tables_are_aligned() -> None:
    text = markdown_table(["figure", "env1"], [["mean", "1.0"], ["greatest of all", "12.5"]])
    lines = text.split("\n")
    assert len({len(line) for line in lines}) == 1
    assert lines[1] == "| --------------- | ---: |"
