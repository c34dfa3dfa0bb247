"""Whole maps saved and loaded: what is written can be read again, and a map holds nothing open."""

from __future__ import annotations

import copy
import os
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from tolman.maps import HybridMap, LocalMap, MapError, MapFile, MapFileError

from tools.torture.maps import map_made_up_world


def three() -> HybridMap:
    hybrid = HybridMap()
    for _ in range(3):
        hybrid.add_node()
    hybrid.add_arc(0, 1, "right", 0.5)
    hybrid.meta = replace(hybrid.meta, current_node=2, arrival="right")
    return hybrid


def relabel(hybrid: HybridMap) -> None:
    hybrid.graph = nx.relabel_nodes(hybrid.graph, str)


def renumber(hybrid: HybridMap) -> None:
    hybrid.graph = nx.convert_node_labels_to_integers(hybrid.graph, first_label=10)


def other_class(hybrid: HybridMap) -> None:
    hybrid.graph = nx.DiGraph(hybrid.graph)


CHANGES: dict[str, tuple[Callable[[HybridMap], Any], str]] = {
    "relabeled": (relabel, "node 0: id = '0': expected a whole number"),
    "renumbered": (renumber, "the robot is said to be at node 2"),
    "another class": (other_class, "the graph is a DiGraph"),
    "raw edge": (lambda hybrid: hybrid.graph.add_edge(0, 2), r"arc 0 -> 2 \(0\)"),
    "raw node": (lambda hybrid: hybrid.graph.add_node(9), "node 9: it has no name"),
    "numpy node": (lambda hybrid: hybrid.graph.add_node(np.int64(9), name="x"), r"node np.int64\(9\)"),
    "float node": (lambda hybrid: hybrid.graph.add_node(7.0, name="x"), r"node 7\.0"),
    "robot's node gone": (lambda hybrid: hybrid.graph.remove_node(2), "at node 2"),
    "no local map": (
        lambda hybrid: hybrid.graph.nodes[1].update(local_map="x"),
        "node 1: its local map is a str",
    ),
    "unknown attribute": (lambda hybrid: hybrid.graph.nodes[1].update(color="red"), "unknown field 'color'"),
    "doubled name": (lambda hybrid: hybrid.graph.nodes[1].update(name="n0"), "its name 'n0' is another's"),
    "far away": (lambda hybrid: hybrid.graph.edges[0, 1, "right"].update(distance=1e30), "distance = 1e"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_graph_that_could_not_be_loaded_is_not_saved(tmp_path: Path, change: str) -> None:
    path, hybrid = tmp_path / "m.tolman", three()
    hybrid.save(path)
    before = path.read_bytes()
    CHANGES[change][0](hybrid)
    with pytest.raises(MapError, match=CHANGES[change][1]) as caught:
        hybrid.save(path, force=True)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["m.tolman"]


def test_a_commit_that_could_not_be_loaded_is_refused_and_the_file_stays(tmp_path: Path) -> None:
    hybrid = three()
    with MapFile.create(tmp_path / "m.tolman") as file:
        file.update(hybrid, hybrid.nodes(), hybrid.graph.edges(keys=True))
        hybrid.graph.remove_node(2)
        with pytest.raises(MapError, match="at node 2, which is not in the map"):
            file.update(hybrid, [2])
        hybrid.meta = replace(hybrid.meta, current_node=None, arrival=None)
        hybrid.graph.remove_node(1)
        with pytest.raises(MapError, match="node 1 was removed, but arcs from or to it are kept"):
            file.update(hybrid, [1])
        hybrid.add_arc(0, hybrid.add_node(node=8), "right", 0.5)
        with pytest.raises(MapError, match="a node that is not in the map"):
            file.update(hybrid, [], [(0, 8, "right")])
    assert HybridMap.load(tmp_path / "m.tolman").nodes() == [0, 1, 2]


def test_every_commit_of_a_map_node_by_node_can_be_loaded(tmp_path: Path) -> None:
    hybrid = three()
    hybrid.meta = replace(hybrid.meta, current_node=None, arrival=None)
    with MapFile.create(tmp_path / "m.tolman") as file:
        for node in hybrid.nodes():
            file.append(hybrid, node)
            assert HybridMap.load(file.path).nodes() == list(range(node + 1))
    assert list(HybridMap.load(tmp_path / "m.tolman").arcs()) == list(hybrid.arcs())


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stored") / "m.tolman"
    map_made_up_world(path, 3, 1)
    return path


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="counts descriptors as Linux shows them")
def test_maps_whose_local_maps_are_unread_hold_no_file_open(stored: Path) -> None:
    before = open_files()
    maps = [HybridMap.load(stored) for _ in range(50)]
    assert open_files() == before
    assert all(hybrid.local_map(1) is not None for hybrid in maps)


def test_a_pickled_map_is_whole_though_its_file_is_gone(stored: Path, tmp_path: Path) -> None:
    path = tmp_path / "m.tolman"
    HybridMap.load(stored).save(path)
    data = pickle.dumps(HybridMap.load(path))
    path.rename(tmp_path / "elsewhere.tolman")
    back = pickle.loads(data)
    back.save(path)
    assert path.read_bytes() == (tmp_path / "elsewhere.tolman").read_bytes()
    local = back.local_map(0)
    with pytest.raises(ValueError, match="read-only"):
        local.hits[0] = 1


def test_a_copy_of_an_unread_map_is_unread_and_has_blocked_edges_of_its_own(stored: Path) -> None:
    hybrid = HybridMap.load(stored)
    twin = copy.deepcopy(hybrid)
    assert repr(twin.local_map(0)) == "LocalMap(not read yet)"
    one, other = hybrid.local_map(0), twin.local_map(0)
    assert one is not None
    assert other is not None
    one.block(*one.edges[0].tolist())
    assert len(one.blocked) == 1
    assert not other.blocked
    assert repr(one).startswith("LocalMap(")


def test_a_local_map_that_was_replaced_in_its_file_is_not_mistaken(stored: Path, tmp_path: Path) -> None:
    path = tmp_path / "m.tolman"
    HybridMap.load(stored).save(path)
    hybrid, other = HybridMap.load(path), HybridMap.load(path)
    other.graph.nodes[1]["local_map"] = LocalMap.build([[0.0, 0.0], [0.1, 0.0]])
    other.save(path, force=True)
    unread, same = hybrid.local_map(1), hybrid.local_map(2)
    assert unread is not None
    assert same is not None
    assert same.metric.units == 25
    with pytest.raises(MapFileError, match="node 1: the local map's bytes do not match"):
        unread.metric  # noqa: B018 - reading raises


@pytest.mark.parametrize("kind", ["pipe", "folder", "broken link"])
def test_only_regular_files_are_replaced(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "m.tolman"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to(tmp_path / "nothing")
    with pytest.raises(MapFileError):
        three().save(path, force=True)
    with pytest.raises(MapFileError):
        MapFile.create(path, force=True)
    assert os.listdir(tmp_path) == ["m.tolman"]
    assert path.is_symlink() or not path.is_file()


def test_a_link_stays_and_the_file_at_its_end_is_replaced(tmp_path: Path) -> None:
    real, link = tmp_path / "real.tolman", tmp_path / "link.tolman"
    HybridMap().save(real)
    link.symlink_to(real)
    three().save(link, force=True)
    with MapFile.resume(link) as file:
        file.append(file.map, file.map.add_node())
    assert link.is_symlink()
    assert HybridMap.load(real).nodes() == [0, 1, 2, 3]
