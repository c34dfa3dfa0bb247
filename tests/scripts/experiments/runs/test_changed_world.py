"""Changed worlds, as experiments: what is changed, and what comes of trips in them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tolman.scripts.experiments.campaign.jobs import CHANGES
from tolman.scripts.experiments.runs.changed_world import change_world, drive_in_changed_world, places_now
from tolman.scripts.experiments.runs.over_map import read_map
from tolman.world.arenas.catalog import find_world
from tolman.world.robot import Pose
from tolman.world.spec import Box


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_world_differs_by_one_box(env1: Path, change: str) -> None:
    spec = find_world("env1")
    changed, box = change_world(spec, change, *read_map(env1), np.random.default_rng(1))
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
def test_in_a_changed_world_it_arrives_or_says_why_not(
    env1: Path, seed: int, settings: dict[str, str | float]
) -> None:
    result = drive_in_changed_world(env1, {**settings, "seed": seed, "change": CHANGES[seed % 4]})
    assert result["outcome"] in ("arrived", "gave up")
    assert result["reason"]
    assert "\n" not in result["reason"]
