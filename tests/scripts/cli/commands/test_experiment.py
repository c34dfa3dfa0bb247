"""`tolman experiment`, with short runs: report, JSON, every table and figure, refusals, a stop."""

import functools
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tolman.maps.local.config import DEFAULT
from tolman.scripts.cli.program import execute
from tolman.scripts.experiments.campaign.kinds import NEEDS
from tolman.scripts.experiments.campaign.version import code_version
from tolman.scripts.experiments.runs import mapping, over_map, training, traversal

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


def test_the_command_writes_report_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    version = code_version()
    out, report = tmp_path / "out.json", tmp_path / "report.md"
    arguments = ["experiment", "table-4.3", "--runs", "1", "--first-seed", "3", "--profile", "thesis"]
    arguments += ["--environments", "env1", "--work", str(tmp_path / "work")]
    assert execute([*arguments, "--json", str(out), "--report", str(report)]) == 0
    values = json.loads(out.read_text(encoding="utf-8"))
    assert values["versions"]["map"] == version
    assert values["tables"]["4.3"][0]["measured"]["thesis"]["runs"] == 1
    assert "# Results" in report.read_text(encoding="utf-8")
    assert capsys.readouterr().out.strip() == f"{report}: written"


@pytest.mark.slow
def test_smoke_runs_every_table_and_draws_every_figure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the kinematic twin, two traversals and one way to train; other tests run profile `thesis`."""
    monkeypatch.setattr(traversal, "TRAVERSALS", 2)
    monkeypatch.setattr(training, "CONFIGURATIONS", {"batch": DEFAULT})
    for module, name in ((mapping, "MapRequest"), (over_map, "RunSettings")):
        monkeypatch.setattr(module, name, functools.partial(getattr(module, name), engine="kinematic"))
    report, figures = tmp_path / "results.md", tmp_path / "figures"
    arguments = ["experiment", "smoke", "--profile", "default", "--first-seed", "4"]
    arguments += ["--work", str(tmp_path / "work"), "--report", str(report), "--figures", str(figures)]
    assert execute(arguments) == 0
    text = report.read_text(encoding="utf-8")
    for table in NEEDS:
        assert f"## Table {table.removeprefix('table-')}:" in text
    assert "**these were used for tuning**" in text
    names = {"paths", "estimates", "metric-soms", "perceptual-soms", "traversals", "corrections"}
    assert {path.stem for path in figures.iterdir()} == names
    capsys.readouterr()
    assert execute([*arguments, "--finished-only"]) == 0
    assert report.read_text(encoding="utf-8") == text


def test_an_unknown_experiment_is_refused_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(["experiment", "table-9", "--work", str(tmp_path / "work")]) == 2
    assert "unknown experiment 'table-9'" in capsys.readouterr().err
    assert execute(["experiment", "shapez", "--work", str(tmp_path / "work")]) == 2
    assert "did you mean 'shapes'?" in capsys.readouterr().err
    assert not (tmp_path / "work").exists()


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_campaign_that_is_stopped_leaves_no_worker_behind(tmp_path: Path, stop: signal.Signals) -> None:
    command = [sys.executable, "-m", "tolman.scripts.cli", "experiment", "table-4.2", "--runs", "200"]
    with subprocess.Popen(
        [*command, "--jobs", "2", "--work", str(tmp_path / "work")],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as campaign:
        assert campaign.stderr is not None
        while "1 of" not in campaign.stderr.readline():
            assert campaign.poll() is None
        campaign.send_signal(stop)
        assert "interrupted" in campaign.stderr.read()
        assert campaign.wait(30) == 130
    assert is_gone(campaign.pid)


def is_gone(group: int) -> bool:
    """Whether all processes of the group, the workers among them, end within ten seconds."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def test_a_study_of_profile_thesis_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["experiment", "ablation", "--profile", "thesis", "--work", str(tmp_path / "work")]
    assert execute(arguments) == 2
    assert "studies are of profile default" in capsys.readouterr().err
