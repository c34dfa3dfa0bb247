"""Targets: how they read."""

from tolman.scripts.experiments.results.targets import Target


def test_a_target_reads_as_its_limits() -> None:
    assert Target((1.0, 1.5, 1.5), (4.0, 4.0, 4.0)).describe(1) == "mean ≤ 1.5, worst ≤ 4"
