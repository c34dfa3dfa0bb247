"""Pages of results: every study has a section, whatever has run."""

import json

import pytest
from tolman.scripts.experiments.page import STUDIES
from tolman.scripts.experiments.studies.study import Asked
from tolman.scripts.plain import plain

ASKED = Asked(runs=2, environments=("env1",))


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_every_study_reports_also_where_nothing_has_run(name: str) -> None:
    study = STUDIES[name]
    assert "none" in study.report(ASKED, {})
    assert json.dumps(plain(study.values(ASKED, {})), allow_nan=False)
