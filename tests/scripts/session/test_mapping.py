"""Mapping as the command line asks for it, in the kinematic twin: what is mapped, reported and kept."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from tolman.agent.mapping.corners import Mapper
from tolman.maps.errors import MapFileError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.storage.map_file import read_truth
from tolman.scripts.session.mapping import MapReport
from tolman.scripts.session.requests import MapRequest, Progress, SessionError
from tolman.scripts.session.simulation import map_world
from tolman.world.robot import Pose

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

ENV1_LOOP = 4.61


def request(output: Path, **fields: object) -> MapRequest:
    values = {"world": "env1", "output": output, "global_only": True, "engine": "kinematic", **fields}
    return MapRequest(**values)  # type: ignore[arg-type]


@pytest.mark.parametrize("side", ["right", "left"])
def test_env1_is_mapped_and_its_loop_closed_at_the_right_place(tmp_path: Path, side: str) -> None:
    report = map_world(request(tmp_path / "env1.tolman", side=side))
    assert (report.loop_closed, report.loop_correct, report.reason) == (True, True, "loop closed")
    assert (report.nodes, report.arcs, report.local_maps, report.collisions) == (10, 20, 0, 0)
    assert report.loop_distance_m == pytest.approx(ENV1_LOOP, abs=0.015)
    assert report.position_error_m < 0.01
    assert report.largest_arc_error_m < 0.01
    assert report.path_integration_error_m > 0.02


@pytest.mark.parametrize(("world", "nodes"), [("env1-mirrored", 10), ("room", 24)])
def test_worlds_that_nothing_was_tuned_on_are_mapped_too(tmp_path: Path, world: str, nodes: int) -> None:
    report = map_world(request(tmp_path / "map.tolman", world=world, seed=3))
    assert (report.nodes, report.loop_correct, report.collisions) == (nodes, True, 0)
    assert report.position_error_m < 0.015


SLANTED = """\
tolman-world: 1
description: a room with walls at 45 degrees, a sharp corner and a blunt one
room: {size: [1.2, 1.0]}
polygons:
  - points: [[1.2, 0.6], [1.2, 1.0], [0.8, 1.0]]
  - points: [[0.0, 0.55], [0.25, 0.8], [0.0, 1.0]]
starts:
  right: [0.5, 0.057, 0]
"""


def test_a_room_with_slanted_walls_is_mapped_corner_by_corner(tmp_path: Path) -> None:
    world = tmp_path / "slanted.yaml"
    world.write_text(SLANTED)
    report = map_world(request(tmp_path / "map.tolman", world=str(world)))
    assert (report.nodes, report.loop_correct, report.collisions) == (7, True, 0)
    assert report.position_error_m < 0.03


def test_the_file_holds_what_was_reported(tmp_path: Path) -> None:
    path = tmp_path / "env1.tolman"
    report = map_world(request(path, seed=5))
    found = HybridMap.load(path)
    assert found.graph.number_of_nodes() == report.nodes
    assert found.graph.number_of_edges() == report.arcs
    assert found.meta.loop_closed
    assert (found.meta.world, found.meta.side, found.meta.seed) == ("env1", "right", 5)
    assert found.meta.current_node in found.graph
    right = [arc for arc in found.arcs() if arc.side == "right"]
    assert sum(arc.distance for arc in right) == pytest.approx(report.loop_distance_m)
    assert [arc.end for arc in right] == [*range(1, 10), 0]
    turns = [found.graph.nodes[node]["turn"] for node in found.nodes()]
    assert sum(turns) == pytest.approx(math.tau, abs=0.35)


def test_the_truth_in_the_file_is_where_the_nodes_are(tmp_path: Path) -> None:
    path = tmp_path / "env1.tolman"
    map_world(request(path, noise="none"))
    truth = read_truth(path)
    places = {(round(x, 2), round(y, 2)) for x, y, _ in (node["pose"] for node in truth.nodes.values())}
    assert {(0.94, 0.06), (0.94, 0.60), (0.06, 0.94), (0.48, 0.06)} <= places
    assert len(truth.nodes) == 10


def test_progress_tells_of_every_node_and_of_the_loop(tmp_path: Path) -> None:
    told: list[Progress] = []
    map_world(request(tmp_path / "env1.tolman"), told.append)
    assert [each.nodes for each in told] == [*range(1, 11), 10]
    assert told[-1].message == "loop closed at node 0"
    assert all(a.time_s < b.time_s for a, b in pairwise(told))


def test_the_same_request_gives_the_same_bytes_and_another_seed_others(tmp_path: Path) -> None:
    one, two, other = (tmp_path / name for name in ("one.tolman", "two.tolman", "other.tolman"))
    map_world(request(one, max_nodes=3))
    map_world(request(two, max_nodes=3))
    map_world(request(other, max_nodes=3, seed=1))
    assert one.read_bytes() == two.read_bytes()
    assert one.read_bytes() != other.read_bytes()


@pytest.mark.parametrize(
    ("fields", "reason"), [({"max_nodes": 3}, "max nodes"), ({"max_time": 20.0}, "max time")]
)
def test_a_limit_ends_a_mapping_and_says_so(tmp_path: Path, fields: dict[str, float], reason: str) -> None:
    report = map_world(request(tmp_path / "map.tolman", **fields))
    assert report.reason == reason
    assert (report.loop_closed, report.loop_correct) == (False, None)
    assert report.nodes == HybridMap.load(tmp_path / "map.tolman").graph.number_of_nodes() > 0
    assert report.sim_time_s <= fields.get("max_time", math.inf) + 0.1


def test_a_start_of_one_s_own_is_taken(tmp_path: Path) -> None:
    report = map_world(request(tmp_path / "map.tolman", start=Pose(0.2, 0.8, 0.5), noise="none"))
    assert (report.nodes, report.loop_correct) == (10, True)


def test_an_existing_file_is_neither_overwritten_nor_harmed(tmp_path: Path) -> None:
    path = tmp_path / "map.tolman"
    map_world(request(path, max_nodes=2))
    before = path.read_bytes()
    with pytest.raises(MapFileError, match="exists already"):
        map_world(request(path, max_nodes=3))
    assert path.read_bytes() == before
    map_world(request(path, max_nodes=3, force=True))
    assert HybridMap.load(path).graph.number_of_nodes() == 3


KILLED = """
import os, sys
from pathlib import Path
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world

def die(progress):
    if progress.nodes == int(sys.argv[2]):
        os._exit(9)

map_world(MapRequest(world="env1", output=Path(sys.argv[1]), global_only=True, engine="kinematic"), die)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, MapReport]:
    """env1 mapped without a stop."""
    path = tmp_path_factory.mktemp("whole") / "env1.tolman"
    return path, map_world(request(path))


@pytest.mark.parametrize("nodes", [4])
def test_a_mapping_that_was_killed_goes_on_to_the_same_bytes(
    tmp_path: Path, whole: tuple[Path, MapReport], nodes: int
) -> None:
    path = tmp_path / "env1.tolman"
    killed = subprocess.run([sys.executable, "-c", KILLED, str(path), str(nodes)], check=False)
    assert killed.returncode == 9
    report = map_world(request(path, resume=True))
    expected = whole[1]
    assert replace(report, wall_time_s=0.0, real_time_factor=0.0) == replace(
        expected, wall_time_s=0.0, real_time_factor=0.0
    )
    assert path.read_bytes() == whole[0].read_bytes()


def test_a_mapping_that_met_its_limit_can_go_on_too(tmp_path: Path, whole: tuple[Path, MapReport]) -> None:
    path = tmp_path / "env1.tolman"
    map_world(request(path, max_nodes=4))
    report = map_world(request(path, resume=True))
    assert (report.nodes, report.loop_correct) == (10, True)
    assert path.read_bytes() == whole[0].read_bytes()


def test_a_map_of_another_world_cannot_be_resumed_and_stays_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "map.tolman"
    map_world(request(path, max_nodes=2))
    before = path.read_bytes()
    with pytest.raises(SessionError, match="a map of env1, not of room: cannot be resumed there"):
        map_world(request(path, world="room", resume=True))
    assert path.read_bytes() == before


def test_a_run_that_another_version_kept_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken_off(progress: Progress) -> None:
        if progress.message.startswith("node 1"):
            raise RuntimeError

    path = tmp_path / "map.tolman"
    monkeypatch.setattr(Mapper, "state", lambda self: {"current": self.current})
    with pytest.raises(RuntimeError):
        map_world(request(path), broken_off)
    with pytest.raises(SessionError, match="kept by another version of tolman; map it afresh, with --force"):
        map_world(request(path, resume=True))


def test_there_must_be_something_to_resume(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match="no such file to resume"):
        map_world(request(tmp_path / "none.tolman", resume=True))


def test_a_report_is_json_without_false_precision(tmp_path: Path) -> None:
    values = map_world(request(tmp_path / "map.tolman", max_nodes=2)).to_json()
    for value in values.values():
        assert value is None or isinstance(value, (bool, int, str)) or value == round(value, 6)
