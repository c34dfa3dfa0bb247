from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest
from tolman.scripts.experiments.campaign.campaign import Job, Result, run_campaign

JOBS = [Job({"seed": seed}) for seed in range(4)]
Drive = Callable[[Mapping[str, Any]], dict[str, Any]]


def make_drive() -> Drive:
    def drive(values: Mapping[str, Any]) -> dict[str, Any]:  # local, so that it is sent by value
        from tolman.world import WheelCommand, open_world

        world = open_world("env2", seed=values["seed"])
        trajectory = []
        for tick in range(100):
            world.robots[0].act(WheelCommand(300.0 + tick, 500.0 - 3.0 * tick))
            world.step()
            pose = world.true_pose()
            trajectory.append([pose.x, pose.y, pose.heading, *world.robots[0].sense().infrared])
        view = float(world.robots[0].look().sum())
        world.close()
        return {"trajectory": trajectory, "view": view}

    return drive


@pytest.fixture(scope="module")
def alone() -> dict[str, Result]:
    return run_campaign(JOBS, make_drive())


@pytest.mark.slow
def test_the_number_of_jobs_changes_no_trajectory(alone: dict[str, Result]) -> None:
    assert len({str(result["trajectory"]) for result in alone.values()}) == len(JOBS)
    assert run_campaign(JOBS, make_drive(), processes=2) == alone
    assert run_campaign(JOBS, make_drive(), processes=3) == alone


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_trajectories(alone: dict[str, Result]) -> None:
    distributed: Any = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        assert run_campaign(JOBS, make_drive(), dask=cluster.scheduler_address) == alone
