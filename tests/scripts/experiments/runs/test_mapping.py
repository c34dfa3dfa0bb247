"""Mapping runs of experiments: the same settings, the same figures."""

from pathlib import Path

import pytest
from tolman.scripts.experiments.campaign.jobs import mapping_job
from tolman.scripts.experiments.runs.mapping import run_mapping


@pytest.mark.slow
def test_the_same_job_gives_the_same_figures(tmp_path: Path) -> None:
    job = mapping_job("env1", "left", 5, "thesis", local_maps=False)
    one, other = (run_mapping(job.settings, tmp_path / name) for name in "ab")
    for timing in ("wall_time_s", "real_time_factor"):
        del one[timing], other[timing]
    assert one == other
