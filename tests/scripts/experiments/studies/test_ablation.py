"""Study `ablation`: each remedy is taken away once."""

from collections.abc import Callable
from typing import Any

from tolman.scripts.experiments.studies.ablation import ABLATION, OF_LOCAL_MAPS, OF_THE_BOUNDARY
from tolman.scripts.experiments.studies.study import Asked
from tolman.scripts.session.profiles import REMEDIES, find_profile

ASKED = Asked(runs=2, environments=("env1",))
Make = Callable[..., Any]


def test_an_ablation_runs_the_whole_profile_and_each_without_one_remedy(mapping: Make, jobs_of: Make) -> None:
    jobs, results = jobs_of(ABLATION, ASKED, mapping())
    profiles = {str(job.settings["profile"]) for job in jobs if job.settings["kind"] == "map"}
    assert profiles == {"default", *(f"default without {r}" for r in {*OF_LOCAL_MAPS, *OF_THE_BOUNDARY})}
    assert {*OF_LOCAL_MAPS, *OF_THE_BOUNDARY} == set(REMEDIES)
    assert all(find_profile(profile) for profile in profiles)
    text = ABLATION.report(ASKED, results)
    assert "| without compass" in text
    assert "| without recognized corners" in text
