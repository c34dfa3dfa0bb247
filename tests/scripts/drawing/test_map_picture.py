"""How a map is laid out without the truth, and what is taken from a file."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.maps.storage.map_file import MapFile
from tolman.scripts.drawing.map_picture import drawing_of
from tolman.scripts.session.truth import node_truth, read_map_truth, run_truth
from tolman.world.arenas.catalog import built_in_world
from tolman.world.robot import Pose


def square(side: float = 1.0, last: float = 1.0, closed: bool = True) -> HybridMap:
    """Four nodes in a square, driven counter-clockwise with the wall on the right."""
    hybrid = HybridMap(MapMeta(world="env1", loop_closed=closed))
    for k in range(4):
        hybrid.add_node(entry_heading=k * math.pi / 2, turn=math.pi / 2, corner="concave")
    for k in range(4 if closed else 3):
        hybrid.add_arc(k, (k + 1) % 4, "right", last if k == 3 else side)
    return hybrid


def places(poses: dict[int, Pose]) -> list[tuple[float, float]]:
    return [(round(pose.x, 9), round(pose.y, 9)) for _, pose in sorted(poses.items())]


@pytest.fixture
def mapped(tmp_path: Path) -> Path:
    """A map file with truth, as a mapping leaves it."""
    hybrid = square()
    hybrid.meta = replace(hybrid.meta, world_digest=built_in_world("env1").digest)
    path = tmp_path / "m.tolman"
    file = MapFile.create(path, hybrid.meta)
    file.map = hybrid
    for node in hybrid.nodes():
        file.append(hybrid, node, truth=node_truth(Pose(node, 2 * node, 0.5), [(node, 0.25), (node, 0.5)]))
    file.update(hybrid, truth={-1: run_truth([(9.0, 9.0)])})
    file.seal()
    return path


def test_the_truth_is_read_back_in_order(mapped: Path) -> None:
    truth = read_map_truth(mapped)
    assert truth is not None
    assert truth.nodes[3] == Pose(3.0, 6.0, 0.5)
    assert truth.track[[0, 1, -2, -1]].tolist() == [[0, 0.25], [0, 0.5], [3, 0.5], [9, 9]]


def test_a_map_with_truth_is_drawn_in_its_world(mapped: Path) -> None:
    drawing = drawing_of(mapped)
    assert drawing.nodes[1] == Pose(1.0, 2.0, 0.5)
    assert drawing.shapes == built_in_world("env1").shapes
    assert len(drawing.track) == 9


def test_a_map_without_truth_is_drawn_alone(tmp_path: Path) -> None:
    square().save(tmp_path / "m.tolman")
    drawing = drawing_of(tmp_path / "m.tolman")
    assert places(dict(drawing.nodes)) == [(0, 0), (0, 1), (-1, 1), (-1, 0)]
    assert not drawing.shapes
    assert not len(drawing.track)


def test_the_walls_of_a_world_that_has_changed_are_left_out(tmp_path: Path, mapped: Path) -> None:
    hybrid = square()
    path = tmp_path / "changed.tolman"
    file = MapFile.create(path, replace(hybrid.meta, world_digest="another"))
    file.update(hybrid, hybrid.nodes(), truth={n: node_truth(Pose(n, 0, 0), []) for n in hybrid.nodes()})
    file.seal()
    assert drawing_of(path).shapes == ()
    assert drawing_of(path, world="env2").shapes == built_in_world("env2").shapes
