"""Studies: their stages follow one another."""

from typing import Any

from tolman.scripts.experiments.campaign.campaign import Job
from tolman.scripts.experiments.studies.study import Asked, Study, run_study

ASKED = Asked(runs=2, environments=("env1",))


def test_a_later_stage_sees_the_results_of_the_earlier(tmp_path: Any) -> None:
    seen: list[int] = []

    def stage(asked: Asked, results: Any) -> dict[str, list[Job]]:
        seen.append(len(results))
        return {}

    study = Study("s", "S", (stage, stage), lambda asked, results: "", lambda asked, results: {})
    assert run_study(study, ASKED, tmp_path) == {}
    assert seen == [0, 0]
