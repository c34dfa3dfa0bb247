"""The runs of the tables: kept, and not run again; which map is driven."""

from pathlib import Path

import pytest
from tolman.scripts.experiments.campaign.campaign import Job, Progress
from tolman.scripts.experiments.campaign.jobs import mapping_job
from tolman.scripts.experiments.campaign.kinds import GLOBAL, LOCAL
from tolman.scripts.experiments.campaign.plan import Outcome, Plan
from tolman.scripts.experiments.campaign.running import Running
from tolman.scripts.experiments.campaign.thesis_runs import average_maps, run_plan
from tolman.scripts.experiments.report.figures import draw_figures

PLAN = Plan(("table-4.3",), 1, 1, 3, ("env1",), ("default", "thesis"))


def _outcome(errors: dict[int, float], finished: dict[int, bool] | None = None) -> Outcome:
    key = (LOCAL, "env1", "default")
    jobs: list[Job] = []
    results = []
    for seed, error in errors.items():
        jobs.append(
            mapping_job("env1", "right" if seed % 2 == 0 else "left", seed, "default", local_maps=True)
        )
        results.append({"position_error_m": error, "finished": (finished or {}).get(seed, True)})
    return Outcome({key: results}, {key: jobs})


def test_the_average_map_is_the_one_nearest_to_its_sides_mean() -> None:
    maps = average_maps(_outcome({0: 0.01, 2: 0.02, 4: 0.06, 1: 0.5}), "env1", "default")
    assert maps["right"].settings["seed"] == 2
    assert maps["left"].settings["seed"] == 1


def test_a_map_that_did_not_get_round_is_never_driven() -> None:
    maps = average_maps(_outcome({0: 0.01, 2: 0.02}, {0: False, 2: False}), "env1", "default")
    assert maps == {}


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
