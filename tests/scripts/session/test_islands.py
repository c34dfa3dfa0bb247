"""Obstacles that stand free: found, mapped, linked and driven to, in the kinematic twin."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tolman.agent.goals import Crossing
from tolman.agent.islands.outlines import outlines
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.storage.map_file import MapFile, read_truth
from tolman.scripts.session.mapping import MapReport
from tolman.scripts.session.requests import GoRequest, MapRequest, SessionError
from tolman.scripts.session.simulation import go_to, map_world
from tolman.scripts.session.trip import GoReport

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

WORLD = """\
tolman-world: 1
description: a room with a box that stands free
room: {size: [0.9, 0.8]}
boxes:
  - corners: [[0.35, 0.30], [0.57, 0.46]]
starts:
  right: [0.5, 0.057, 0]
  left: [0.5, 0.057, 180]
"""


def request(world: Path, output: Path, **fields: object) -> MapRequest:
    values = {"world": str(world), "output": output, "global_only": True, "engine": "kinematic", **fields}
    return MapRequest(islands=True, **values)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The world's file."""
    path = tmp_path_factory.mktemp("islands") / "box.yaml"
    path.write_text(WORLD)
    return path


@pytest.fixture(scope="module")
def mapped(world: Path) -> tuple[Path, MapReport]:
    """The map of it."""
    path = world.with_name("box.tolman")
    return path, map_world(request(world, path, seed=2))


def go(path: Path, world: Path, to: int, **fields: object) -> GoReport:
    return go_to(
        GoRequest(map=path, to=to, world=str(world), engine="kinematic", **fields)  # type: ignore[arg-type]
    )


def test_the_island_is_found_mapped_and_linked_both_ways(mapped: tuple[Path, MapReport]) -> None:
    path, report = mapped
    assert (report.islands, report.scouted, report.reason) == (1, "all is covered", "loop closed")
    assert (report.nodes, report.loop_correct, report.collisions) == (8, True, 0)
    assert report.position_error_m < 0.02
    found = HybridMap.load(path)
    assert found.meta.loop_closed
    room, island = outlines(found)
    assert room.turning == -island.turning
    links = [arc for arc in found.arcs() if arc.kind == "foray"]
    assert {arc.start in island.nodes for arc in links} == {True, False}
    assert all(Crossing(**arc.notes["crossing"]) for arc in links)
    assert all(arc.traversals > 0 for arc in links)


def test_the_island_lies_where_it_is(mapped: tuple[Path, MapReport]) -> None:
    found, truth = HybridMap.load(mapped[0]), read_truth(mapped[0])
    room, island = outlines(found)
    places = {node: truth.nodes[node]["pose"] for node in found.nodes()}
    for outline in (room, island):
        for node, (x, y) in zip(outline.nodes, outline.points, strict=True):
            apart = ((x - room.points[0][0]) ** 2 + (y - room.points[0][1]) ** 2) ** 0.5
            (tx, ty, _), (ox, oy, _) = places[node], places[0]
            assert apart == pytest.approx(((tx - ox) ** 2 + (ty - oy) ** 2) ** 0.5, abs=0.05)


def test_it_drives_to_the_island_and_back_by_forays(mapped: tuple[Path, MapReport], world: Path) -> None:
    path = mapped[0]
    room, island = outlines(HybridMap.load(path))
    for seed, (start, end) in enumerate([(room.nodes[2], island.nodes[2]), (island.nodes[1], room.nodes[1])]):
        report = go(path, world, end, origin=start, seed=seed)
        assert report.reached
        assert [leg["kind"] for leg in report.legs].count("foray") == 1
        assert report.position_error_m is not None
        assert report.position_error_m < 0.02


def test_a_foray_that_is_driven_teaches_its_own_arc(mapped: tuple[Path, MapReport], world: Path) -> None:
    path = world.with_name("learned.tolman")
    path.write_bytes(mapped[0].read_bytes())
    before = HybridMap.load(path)
    room, island = outlines(before)
    assert go(path, world, island.nodes[0], origin=room.nodes[0], learn=True).reached
    counts = [
        {(arc.start, arc.end): arc.traversals for arc in found.arcs() if arc.kind == "foray"}
        for found in (before, HybridMap.load(path))
    ]
    assert sum(counts[1].values()) == sum(counts[0].values()) + 1


def test_dropped_anywhere_it_finds_its_place_though_the_island_looks_the_same_twice(
    mapped: tuple[Path, MapReport], world: Path
) -> None:
    room, island = outlines(HybridMap.load(mapped[0]))
    report = go(mapped[0], world, room.nodes[0], lost=True, seed=4)
    assert report.localized_node is None or report.localized_node in (*room.nodes, *island.nodes)
    assert report.reached is not report.lost


KILLED = """
import os, sys
from pathlib import Path
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world

def die(progress):
    if progress.message.startswith(sys.argv[3]):
        os._exit(9)

map_world(MapRequest(world=sys.argv[1], output=Path(sys.argv[2]), global_only=True, engine="kinematic",
                     seed=2, islands=True), die)
"""


@pytest.mark.parametrize("message", ["node 6", "3 forays"])
def test_a_search_that_was_killed_goes_on_to_the_same_bytes(
    tmp_path: Path, mapped: tuple[Path, MapReport], world: Path, message: str
) -> None:
    path = tmp_path / "box.tolman"
    killed = subprocess.run([sys.executable, "-c", KILLED, str(world), str(path), message], check=False)
    assert killed.returncode == 9
    report = map_world(request(world, path, seed=2, resume=True))
    assert replace(report, wall_time_s=0.0, real_time_factor=0.0) == replace(
        mapped[1], wall_time_s=0.0, real_time_factor=0.0
    )
    assert path.read_bytes() == mapped[0].read_bytes()


def test_a_search_is_resumed_as_it_was_begun(tmp_path: Path, world: Path) -> None:
    path = tmp_path / "box.tolman"
    map_world(request(world, path, max_nodes=2))
    with pytest.raises(SessionError, match="begun with --islands: resume it in the same way"):
        map_world(replace(request(world, path, resume=True), islands=False))


def test_the_published_method_has_no_forays(tmp_path: Path, world: Path) -> None:
    with pytest.raises(SessionError, match="profile 'thesis' has no forays"):
        map_world(request(world, tmp_path / "box.tolman", profile="thesis"))


def test_a_foray_without_a_way_to_drive_it_is_refused_in_one_line(
    mapped: tuple[Path, MapReport], world: Path
) -> None:
    path = world.with_name("bare.tolman")
    path.write_bytes(mapped[0].read_bytes())
    with MapFile.resume(path) as file:
        links = [arc for arc in file.map.arcs() if arc.kind == "foray"]
        for arc in links:
            file.map.annotate((arc.start, arc.end, arc.kind), crossing=None)
        file.update(file.map, arcs=[(arc.start, arc.end, arc.kind) for arc in links])
    room, island = outlines(HybridMap.load(path))
    report = go(path, world, island.nodes[0], origin=room.nodes[0])
    assert not report.reached
    assert "its notes lack 'crossing', how it is driven" in report.reason


@pytest.mark.parametrize("seed", range(3))
def test_a_round_obstacle_is_left_again_each_time_it_is_met(tmp_path: Path, seed: int) -> None:
    """No corner tells a robot where on it it is: it must not go round and round."""
    world = tmp_path / "round.yaml"
    world.write_text(
        "tolman-world: 1\nroom: {size: [1.5, 1.5]}\ncylinders: [{at: [0.8, 0.7], radius: 0.12}]\n"
    )
    report = map_world(
        MapRequest(
            world=str(world),
            output=tmp_path / "round.tolman",
            global_only=True,
            islands=True,
            engine="kinematic",
            seed=seed,
            max_time=4000.0,
        )
    )
    assert report.reason == "loop closed"
    assert report.scouted == "all is covered"
    assert report.collisions == 0
