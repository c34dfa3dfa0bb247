"""Whole runs in DART: explore, save, and find the way in another process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tolman.maps.hybrid_map import HybridMap
from tolman.scripts.session.requests import GoRequest, MapRequest
from tolman.scripts.session.simulation import go_to, map_world

pytestmark = pytest.mark.e2e


def tolman(*arguments: object) -> tuple[int, dict[str, Any]]:
    """Exit status and JSON of a command in a process of its own."""
    command = [sys.executable, "-m", "tolman.scripts.cli", *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.stdout, done.stderr
    values: dict[str, Any] = json.loads(done.stdout)
    return done.returncode, values


@pytest.fixture(scope="module")
def env1(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """env1 mapped by the command, and what it reported."""
    path = tmp_path_factory.mktemp("e2e") / "env1.tolman"
    status, report = tolman("map", "env1", "-o", path, "--global-only")
    assert status == 0
    return path, report


def test_env1_is_mapped_with_a_loop_within_a_centimeter_and_no_contact(
    env1: tuple[Path, dict[str, Any]],
) -> None:
    _, report = env1
    assert report["loop_correct"] is True
    assert (report["nodes"], report["arcs"], report["collisions"]) == (10, 20, 0)
    assert report["position_error_m"] < 0.01
    assert abs(report["loop_distance_m"] - 4.61) < 0.014
    assert report["path_integration_error_m"] > 0.05


def test_another_process_finds_its_way_with_the_map(env1: tuple[Path, dict[str, Any]]) -> None:
    path, _ = env1
    status, report = tolman("go", path, "--to", 5, "--from", 8)
    assert status == 0
    assert (report["reached"], report["lost"]) == (True, False)
    assert report["path"] == [8, 7, 6, 5]
    assert report["position_error_m"] < 0.01
    assert report["heading_error_deg"] < 6.0


def test_the_same_command_gives_the_same_bytes(env1: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    path, _ = env1
    again = tmp_path / "again.tolman"
    map_world(MapRequest(world="env1", output=again, global_only=True))
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.parametrize(("world", "side", "nodes"), [("env1", "left", 10), ("env1-mirrored", "right", 10)])
def test_the_other_hand_and_the_mirrored_room_are_mapped_as_well(
    tmp_path: Path, world: str, side: str, nodes: int
) -> None:
    report = map_world(
        MapRequest(world=world, output=tmp_path / "m.tolman", side=side, global_only=True, seed=1)
    )
    assert (report.nodes, report.loop_correct, report.collisions) == (nodes, True, 0)
    assert report.position_error_m < 0.01


def test_a_room_with_many_corners_is_mapped(tmp_path: Path) -> None:
    report = map_world(MapRequest(world="room", output=tmp_path / "room.tolman", global_only=True, seed=1))
    assert (report.nodes, report.loop_correct, report.collisions) == (24, True, 0)
    assert report.position_error_m < 0.015


KILLED = """
import os, sys
from pathlib import Path
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world

def die(progress):
    if progress.nodes == 5:
        os._exit(9)

map_world(MapRequest(world="env1", output=Path(sys.argv[1]), global_only=True), die)
"""


def test_a_mapping_that_was_killed_goes_on_to_the_same_bytes(
    env1: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    path = tmp_path / "env1.tolman"
    assert subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode == 9
    map_world(MapRequest(world="env1", output=path, global_only=True, resume=True))
    assert path.read_bytes() == env1[0].read_bytes()


def test_local_maps_are_explored_trained_saved_and_left_at_the_node(tmp_path: Path) -> None:
    path = tmp_path / "local.tolman"
    report = map_world(MapRequest(world="env1", output=path, max_nodes=2))
    assert (report.nodes, report.local_maps, report.reason) == (2, 2, "max nodes")
    assert report.collisions == 0
    assert report.position_error_m < 0.01
    found = HybridMap.load(path)
    for node in found.nodes():
        local = found.local_map(node)
        assert local is not None
        assert local.perceptual is not None
        assert local.entry_panorama is not None
        assert local.entry_panorama.shape == (4, 16, 16)
        assert local.metric.weights.shape == (25, 2)
    back = go_to(GoRequest(map=path, to=0))
    assert (back.reached, back.path) == (True, (1, 0))
    assert back.position_error_m is not None
    assert back.position_error_m < 0.01
