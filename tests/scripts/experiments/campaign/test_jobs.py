"""Jobs: a run on a map names the mapping that makes it."""

from pathlib import Path

from tolman.scripts.experiments.campaign.jobs import map_job_of, map_path, mapping_job, trip_job


def test_a_traversal_names_the_mapping_whose_map_it_drives() -> None:
    job = mapping_job("env2", "left", 7, "thesis", local_maps=True)
    assert map_job_of(trip_job("traverse", job, 8, corrected=True).settings).key == job.key


def test_maps_of_different_runs_do_not_share_a_file() -> None:
    one = mapping_job("env1", "right", 1, "default", local_maps=True)
    other = mapping_job("env1", "right", 1, "default", local_maps=False)
    assert map_path(Path("w"), one) != map_path(Path("w"), other)
