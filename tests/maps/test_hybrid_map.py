from __future__ import annotations

import copy
import math
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.maps.boundary.layout import layout
from tolman.maps.errors import MapError, NoPathError, UnknownNodeError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta


def ring(size: int = 6, length: float = 0.5) -> HybridMap:
    hybrid = HybridMap(MapMeta(world="ring"))
    for index in range(size):
        turn = math.tau / size
        hybrid.add_node(corner="concave", turn=turn, entry_heading=math.remainder(index * turn, math.tau))
    for index in range(size):
        hybrid.add_arc(index, (index + 1) % size, "right", length, 1e-4)
    return hybrid


def test_an_arc_is_joined_by_one_back_along_the_other_side() -> None:
    hybrid = ring()
    back = hybrid.arc(1, 0, "left")
    assert (back.side, back.distance, back.traversals) == ("left", 0.5, 1)
    assert {arc.kind for arc in hybrid.leaving(0)} == {"right", "left"}
    assert len(list(hybrid.arcs())) == 12


def test_two_nodes_may_be_joined_by_right_left_and_foray() -> None:
    hybrid = ring(2)
    hybrid.add_arc(0, 1, "right", 0.3, kind="foray", notes={"heading": 1.5})
    assert sorted(hybrid.graph[0][1]) == ["foray", "left", "right"]
    assert hybrid.arc(1, 0, "foray").side == "left"
    assert hybrid.path(0, 1)[0].kind == "foray"


def test_paths_take_the_shorter_way_round_and_avoid_blocked_arcs() -> None:
    hybrid = ring()
    assert [arc.end for arc in hybrid.path(0, 2)] == [1, 2]
    assert [arc.kind for arc in hybrid.path(0, 5)] == ["left"]
    hybrid.block(0, 1, "right")
    assert [arc.end for arc in hybrid.path(0, 2)] == [5, 4, 3, 2]
    hybrid.block(0, 5, "left")
    with pytest.raises(NoPathError, match="node 0 to node 2"):
        hybrid.path(0, 2)
    assert hybrid.path(4, 4) == []


def test_networkx_runs_on_the_graph_as_it_is() -> None:
    graph = ring().graph
    assert nx.shortest_path_length(graph, 0, 3, weight="distance") == pytest.approx(1.5)
    assert nx.is_strongly_connected(graph)
    assert set(graph.edges[0, 1, "right"]) == {
        "side",
        "distance",
        "variance",
        "traversals",
        "blocked",
        "notes",
    }


@given(st.lists(st.floats(0.1, 2.0), min_size=1, max_size=30))
def test_an_arc_learns_the_mean_and_variance_of_its_traversals(driven: list[float]) -> None:
    hybrid = ring()
    for distance in driven:
        arc = hybrid.record_traversal(0, 1, "right", distance)
    every = [0.5, *driven]
    mean = sum(every) / len(every)
    assert arc.traversals == len(every)
    assert arc.distance == pytest.approx(mean)
    squares = sum((value - mean) ** 2 for value in every)
    expected = (squares + 1e-4) / len(every)  # the variance it began with counts as one traversal's
    assert arc.variance == pytest.approx(expected, abs=1e-9)
    assert hybrid.arc(1, 0, "left").distance == arc.distance


def test_a_traversal_of_one_way_only_leaves_the_way_back() -> None:
    hybrid = ring()
    hybrid.record_traversal(0, 1, "right", 0.7, both_ways=False)
    assert hybrid.arc(1, 0, "left").distance == 0.5


def test_unknown_nodes_and_arcs_name_the_known_ones() -> None:
    hybrid = ring()
    with pytest.raises(UnknownNodeError, match="no node 77 in this map; known: 0, 1, 2"):
        hybrid.path(0, 77)
    with pytest.raises(UnknownNodeError, match="no node 'kitchen'"):
        hybrid.find("kitchen")
    with pytest.raises(UnknownNodeError, match="between them: right"):
        hybrid.arc(0, 1, "foray")


def test_nodes_are_found_by_number_text_and_name() -> None:
    hybrid = ring()
    hybrid.rename(3, "kitchen")
    assert [hybrid.find(3), hybrid.find("3"), hybrid.find("kitchen"), hybrid.find("n2")] == [3, 3, 3, 2]


@pytest.mark.parametrize("name", ["", "x" * 201, "a\nb", "n5", "7", "n1"])
def test_names_that_would_mislead_are_refused(name: str) -> None:
    with pytest.raises(MapError):
        ring().rename(3, name)


def test_notes_are_added_and_taken_away() -> None:
    hybrid = ring()
    hybrid.annotate(2, color="red", floor=1)
    hybrid.annotate(2, color=None)
    hybrid.annotate((0, 1, "right"), narrow=True)
    assert hybrid.graph.nodes[2]["notes"] == {"floor": 1}
    assert hybrid.arc(0, 1, "right").notes == {"narrow": True}


def test_removing_a_node_takes_its_arcs_and_the_robot_off_it() -> None:
    hybrid = ring()
    hybrid.meta = MapMeta(current_node=3, arrival="right")
    hybrid.remove_node(3)
    assert hybrid.meta.current_node is None
    assert all(3 not in (arc.start, arc.end) for arc in hybrid.arcs())
    assert hybrid.add_node() == 6


@pytest.mark.parametrize(
    "values",
    [
        {"side": "up"},
        {"distance": -1.0},
        {"distance": math.nan},
        {"variance": math.inf},
        {"kind": "left"},
        {"kind": "tunnel"},
    ],
)
def test_arcs_with_impossible_values_are_refused(values: dict[str, object]) -> None:
    hybrid = ring()
    given_values: dict[str, object] = {"side": "right", "distance": 0.5, "variance": 0.0, **values}
    with pytest.raises(MapError):
        hybrid.add_arc(0, 3, **given_values)  # type: ignore[arg-type]
    assert len(list(hybrid.arcs())) == 12


def test_an_arc_cannot_be_added_twice() -> None:
    with pytest.raises(MapError, match="exists already"):
        ring().add_arc(0, 1, "right", 0.5)


@pytest.mark.parametrize("node", [7.0, np.int64(7), "7", -1, 2**63, True])
def test_a_node_is_numbered_by_a_whole_number(node: Any) -> None:
    with pytest.raises(MapError, match="expected a whole number from 0"):
        ring().add_node(node=node)


def test_a_map_can_be_copied_and_the_copy_changed() -> None:
    hybrid = ring()
    other = copy.deepcopy(hybrid)
    other.remove_node(0)
    assert 0 in hybrid.graph


def test_a_map_says_what_is_in_it() -> None:
    hybrid = ring()
    assert repr(hybrid) == "HybridMap('ring', 6 nodes, 12 arcs, 0 local maps, open)"
    hybrid.graph.nodes[0]["local_map"] = LocalMap.build([[0.0, 0.0]])
    hybrid.meta = MapMeta(world="ring", loop_closed=True)
    assert repr(hybrid) == "HybridMap('ring', 6 nodes, 12 arcs, 1 local map, closed)"


def test_a_ring_is_laid_out_closed_whatever_its_lengths_say() -> None:
    hybrid = ring()
    hybrid.graph.edges[0, 1, "right"]["distance"] = 0.52
    places = layout(hybrid)
    sides = [math.dist(places[i], places[(i + 1) % 6]) for i in range(6)]
    assert max(sides) - min(sides) < 0.05


@pytest.mark.parametrize(
    "values", [{"seed": True}, {"seed": "x"}, {"loop_closed": 1}, {"versions": 5}, {"scalars": {"a": [1]}}]
)
def test_meta_of_a_wrong_type_is_refused(values: dict[str, object]) -> None:
    with pytest.raises(MapError):
        MapMeta(**values)  # type: ignore[arg-type]
