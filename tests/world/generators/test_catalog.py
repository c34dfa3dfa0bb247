"""Worlds drawn from seeds: the same bytes for the same seed, and each one can be opened and driven in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from tolman.world import WorldError, find_world
from tolman.world.generators.catalog import KINDS, make_world
from tolman.world.geometry import Plan
from tolman.world.robot import EPUCK
from tolman.world.spec import Shape

SMALL = [kind for kind in KINDS if kind not in ("building", "contest")]


def written(kind: str, seed: int, folder: Path) -> Path:
    drawn = make_world(kind, seed, "drawn")
    path = folder / "drawn.yaml"
    path.write_text(drawn.text)
    for ending, data in drawn.beside.items():
        path.with_suffix(ending).write_bytes(data)
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_the_same_files_and_another_seed_others(kind: str) -> None:
    assert make_world(kind, 7) == make_world(kind, 7)
    assert make_world(kind, 7) != make_world(kind, 8)


@pytest.mark.parametrize("kind", SMALL)
@pytest.mark.parametrize("seed", range(5))
def test_a_drawn_world_opens_with_room_for_the_robot_where_it_starts(
    kind: str, seed: int, tmp_path: Path
) -> None:
    spec = find_world(written(kind, seed, tmp_path))
    assert {"right", "left"} <= {start.name for start in spec.starts}
    plan = Plan(spec.shapes)
    assert all(plan.clearance(s.pose.x, s.pose.y) > EPUCK.body_radius for s in spec.starts)


@pytest.mark.parametrize(("kind", "least"), [("building", 400), ("contest", 100)])
def test_large_worlds_are_large(kind: str, least: int, tmp_path: Path) -> None:
    assert len(find_world(written(kind, 0, tmp_path)).shapes) >= least


def test_a_scan_has_free_unknown_and_occupied_cells() -> None:
    image = make_world("scan", 3).beside[".pgm"]
    cells = np.frombuffer(image.split(b"255\n", 1)[1], dtype=np.uint8)
    assert set(np.unique(cells)) == {0, 205, 254}


def test_braided_mazes_have_walls_that_stand_free(tmp_path: Path) -> None:
    tree = find_world(written("maze", 1, tmp_path))
    braided = find_world(written("islands", 1, tmp_path))
    assert _parts(tree.shapes) == 1 < _parts(braided.shapes)


def _parts(shapes: Sequence[Shape]) -> int:
    """How many groups of walls there are that touch."""
    plans = [Plan((shape,)) for shape in shapes]
    groups: list[set[int]] = []
    for index in range(len(shapes)):
        touching = {index, *(other for other in range(len(shapes)) if _touch(shapes, plans, index, other))}
        groups = [
            *(group for group in groups if not group & touching),
            touching.union(*(group for group in groups if group & touching)),
        ]
    return len(groups)


def _touch(shapes: Sequence[Shape], plans: Sequence[Plan], one: int, other: int) -> bool:
    pairs = ((plans[one], shapes[other]), (plans[other], shapes[one]))
    return any(plan.clearance(*corner) < 1e-6 for plan, shape in pairs for corner in shape.outline())


def test_an_unknown_kind_is_refused_with_those_there_are() -> None:
    with pytest.raises(WorldError, match=r"unknown kind of worlds 'castle'; known: .*scan"):
        make_world("castle", 0)
    with pytest.raises(WorldError, match="not -1"):
        make_world("maze", -1)
