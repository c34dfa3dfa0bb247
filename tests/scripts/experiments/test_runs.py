"""Experiments from the command line, with short runs: resumed, independent of the processes, drawn."""

import functools
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from tolman.maps.local.training import DEFAULT
from tolman.scripts.cli.program import execute
from tolman.scripts.experiments.campaign.campaign import Progress
from tolman.scripts.experiments.campaign.plan import GLOBAL, NEEDS, Plan, run_plan
from tolman.scripts.experiments.campaign.running import Running
from tolman.scripts.experiments.campaign.version import code_version
from tolman.scripts.experiments.report.figures import draw_figures
from tolman.scripts.experiments.runs import mapping, probes, traversal
from tolman.scripts.experiments.runs.mapping import map_path, mapping_job, run_mapping
from tolman.scripts.experiments.runs.traversal import run_traversal, traversal_job

PLAN = Plan(("table-4.3",), 1, 1, 3, ("env1",), ("default", "thesis"))


@pytest.mark.slow
def test_finished_runs_are_not_run_again_and_figures_are_drawn(tmp_path: Path) -> None:
    told: list[tuple[str, Progress]] = []
    first = run_plan(PLAN, tmp_path)
    running = Running(progress=lambda what, progress: told.append((what, progress)))
    again = run_plan(PLAN, tmp_path, running)
    assert again.results == first.results
    assert ("default", Progress(1, 1, None)) in told
    assert ("thesis", Progress(1, 1, None)) in told
    pictures = draw_figures(PLAN, again, tmp_path, tmp_path / "figures", tmp_path)
    assert [(tmp_path / path).stat().st_size > 10_000 for _, path in pictures] == [True, True]
    thesis = first.of(GLOBAL, "env1", "thesis")[0]
    assert thesis["reason"] == "lap"
    assert thesis["path_integration_error_m"] > 0.01


@pytest.mark.slow
def test_a_map_of_profile_thesis_is_driven_by_its_distances(tmp_path: Path) -> None:
    job = mapping_job("env1", "right", 3, "thesis", local_maps=False, noise="none")
    result = run_traversal(traversal_job(job, 4, corrected=False).settings, tmp_path)
    assert map_path(tmp_path, job).exists()
    assert len(result["before"]) >= 5
    assert result["end_error_m"] >= 0.0


@pytest.mark.slow
def test_the_same_job_gives_the_same_figures(tmp_path: Path) -> None:
    job = mapping_job("env1", "left", 5, "thesis", local_maps=False)
    one, other = (run_mapping(job.settings, tmp_path / name) for name in "ab")
    for timing in ("wall_time_s", "real_time_factor"):
        del one[timing], other[timing]
    assert one == other


def test_the_command_writes_report_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    version = code_version()
    plan = replace(PLAN, profiles=("thesis",), first_seed=3)
    assert plan.kinds == {GLOBAL}
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
    monkeypatch.setattr(probes, "CONFIGURATIONS", {"batch": DEFAULT})
    for module, name in ((mapping, "MapRequest"), (traversal, "Simulation")):
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
    assert "did you mean shapes?" in capsys.readouterr().err
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
