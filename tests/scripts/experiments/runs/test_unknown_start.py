"""Starts that the robot is not told, as experiments: what is drawn and scored."""

from pathlib import Path

import pytest
from tolman.scripts.experiments.runs.unknown_start import DISTANCES, drop_pose, find_place
from tolman.world.arenas.catalog import find_world
from tolman.world.geometry import Plan


@pytest.mark.parametrize("drop", sorted(DISTANCES))
def test_a_robot_is_dropped_inside_at_the_distance_asked_for(drop: str) -> None:
    plan = Plan(find_world("env2").shapes)
    poses = [drop_pose(plan, drop, seed) for seed in range(30)]
    nearest, farthest = DISTANCES[drop]
    for pose in poses:
        assert not plan.contains(pose.x, pose.y)
        assert nearest <= plan.clearance(pose.x, pose.y) <= farthest
    assert len({(pose.x, pose.y) for pose in poses}) == len(poses)
    assert drop_pose(plan, drop, 3) == poses[3]


@pytest.mark.parametrize("drop", sorted(DISTANCES))
def test_an_unknown_start_is_found_and_scored(
    env1: Path, drop: str, settings: dict[str, str | float]
) -> None:
    result = find_place(env1, {**settings, "seed": 3, "drop": drop})
    assert result["outcome"] == "right"
    assert result["error_m"] < 0.02
    assert 0.0 < result["share"] < 0.7
    assert result["after_m"] == pytest.approx(result["share"] * result["loop_m"])
