"""The runs that a study is made of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from tolman.scripts.experiments.campaign.campaign import Job, Result
from tolman.scripts.experiments.studies.study import Asked, Study


@pytest.fixture(scope="session")
def jobs_of(trip: Callable[..., Result]) -> Callable[..., Any]:
    """`jobs_of(study, asked, mapped)`: all jobs of a study whose mappings end as `mapped`, and results."""

    def jobs_of(study: Study, asked: Asked, mapped: Result) -> tuple[list[Job], dict[str, Result]]:
        jobs: list[Job] = []
        results: dict[str, Result] = {}
        for stage in study.stages:
            for group in stage(asked, results).values():
                jobs += group
                results |= {job.key: mapped if job.settings["kind"] == "map" else trip() for job in group}
        return jobs, results

    return jobs_of
