"""Starts that the robot is not told, and changed worlds, as experiments: what is drawn and reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.storage.map_file import read_truth
from tolman.scripts.experiments.runs.beyond import DROPS, drop_pose, find_place
from tolman.scripts.experiments.runs.changes import CHANGES, change_world, drive_in_changed_world, places_now
from tolman.scripts.session import map_world
from tolman.scripts.session.requests import MapRequest
from tolman.world.arenas.catalog import find_world
from tolman.world.geometry import Plan
from tolman.world.robot import Pose
from tolman.world.spec import Box

SETTINGS = {
    "map world": "env1",
    "map profile": "default",
    "map noise": "thesis",
    "map noise_scale": 1.0,
    "engine": "kinematic",
}


@pytest.fixture(scope="module")
def env1(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """env1 mapped."""
    path = tmp_path_factory.mktemp("beyond") / "env1.tolman"
    map_world(MapRequest(world="env1", output=path, global_only=True, engine="kinematic", seed=2))
    return path


@pytest.mark.parametrize("drop", sorted(DROPS))
def test_a_robot_is_dropped_inside_at_the_distance_asked_for(drop: str) -> None:
    plan = Plan(find_world("env2").shapes)
    poses = [drop_pose(plan, drop, seed) for seed in range(30)]
    nearest, farthest = DROPS[drop]
    for pose in poses:
        assert not plan.contains(pose.x, pose.y)
        assert nearest <= plan.clearance(pose.x, pose.y) <= farthest
    assert len({(pose.x, pose.y) for pose in poses}) == len(poses)
    assert drop_pose(plan, drop, 3) == poses[3]


@pytest.mark.parametrize("drop", sorted(DROPS))
def test_an_unknown_start_is_found_and_scored(env1: Path, drop: str) -> None:
    result = find_place(env1, {**SETTINGS, "seed": 3, "drop": drop})
    assert result["outcome"] == "right"
    assert result["error_m"] < 0.02
    assert 0.0 < result["share"] < 0.7
    assert result["after_m"] == pytest.approx(result["share"] * result["loop_m"])


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_world_differs_by_one_box(env1: Path, change: str) -> None:
    spec, found, truth = find_world("env1"), HybridMap.load(env1), read_truth(env1)
    changed, box = change_world(spec, change, found, truth, np.random.default_rng(1))
    before, after = set(spec.shapes), set(changed.shapes)
    assert {"added": (0, 1), "shut": (0, 1), "removed": (1, 0), "moved": (1, 1)}[change] == (
        len(before - after),
        len(after - before),
    )
    assert box in (before | after)


def test_a_node_at_a_box_that_was_moved_moves_with_it() -> None:
    spec = find_world("env1")
    box = spec.shapes[4]
    assert isinstance(box, Box)
    moved = replace(box, x=box.x + 0.1)
    changed = replace(spec, shapes=(*spec.shapes[:4], moved, *spec.shapes[5:]))
    corner = Pose(box.x - box.width / 2 - 0.057, box.y + box.depth / 2 + 0.057, 0.0)
    old, new = places_now(corner, spec, changed)
    assert old == corner
    assert new.x - old.x == pytest.approx(0.1)
    assert new.y == corner.y
    assert places_now(Pose(0.06, 0.94, 0.0), spec, changed) == [Pose(0.06, 0.94, 0.0)]
    assert places_now(corner, spec, replace(spec, shapes=spec.shapes[:4])) == [corner]


@pytest.mark.parametrize("seed", [3, 14])
def test_in_a_changed_world_it_arrives_or_says_why_not(env1: Path, seed: int) -> None:
    result = drive_in_changed_world(env1, {**SETTINGS, "seed": seed, "change": CHANGES[seed % 4]})
    assert result["outcome"] in ("arrived", "gave up")
    assert result["reason"]
    assert "\n" not in result["reason"]
