"""Traversal runs of experiments."""

from pathlib import Path

import pytest
from tolman.scripts.experiments.campaign.jobs import map_path, mapping_job, trip_job
from tolman.scripts.experiments.runs.traversal import _slope, run_traversal


@pytest.mark.slow
def test_a_map_of_profile_thesis_is_driven_by_its_distances(tmp_path: Path) -> None:
    job = mapping_job("env1", "right", 3, "thesis", local_maps=False, noise="none")
    result = run_traversal(trip_job("traverse", job, 4, corrected=False).settings, tmp_path)
    assert map_path(tmp_path, job).exists()
    assert len(result["before"]) >= 5
    assert result["end_error_m"] >= 0.0


def test_the_growth_of_an_error_is_its_slope() -> None:
    assert _slope([0.0, 0.01, 0.02, 0.03, 0.04]) == pytest.approx(0.01)
    assert _slope([0.1]) is None
