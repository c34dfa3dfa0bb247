from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.exploration.rigid_graph import Cell, RigidGraph

odd = st.integers(0, 4).map(lambda half: 2 * half + 1)
lattices = st.builds(RigidGraph, odd, odd, st.floats(0.02, 0.2))


def spacing(lattice: RigidGraph) -> float:
    return min((lattice.distance(a, b) for a, b in lattice.graph.edges), default=0.0)


@given(lattices)
def test_the_center_is_the_node_itself(lattice: RigidGraph) -> None:
    assert lattice.places[lattice.center] == (0.0, 0.0)
    assert len(lattice.places) == lattice.rows * lattice.columns


@given(lattices)
def test_neighbors_are_one_spacing_apart_and_six_at_most(lattice: RigidGraph) -> None:
    for a, b in lattice.graph.edges:
        assert lattice.distance(a, b) == pytest.approx(spacing(lattice), rel=1e-9)
    assert all(degree <= 6 for _, degree in lattice.graph.degree)


def test_the_middle_of_the_published_lattice_has_six_neighbors() -> None:
    lattice = RigidGraph()
    assert lattice.graph.degree[lattice.center] == 6
    assert spacing(lattice) == pytest.approx(0.05)


@given(lattices, st.sampled_from(["rows", "columns"]))
def test_both_strategies_visit_every_node_once(lattice: RigidGraph, strategy: str) -> None:
    order = lattice.order(strategy)
    assert len(order) == len(set(order)) == len(lattice.places)


@pytest.mark.parametrize("strategy", ["rows", "columns"])
def test_the_order_goes_back_and_forth(strategy: str) -> None:
    lattice = RigidGraph()
    order = lattice.order(strategy)
    assert all(lattice.distance(a, b) < 0.1 for a, b in pairwise(order))


@given(lattices, st.data())
def test_a_path_goes_from_neighbor_to_neighbor(lattice: RigidGraph, data: st.DataObject) -> None:
    cells = st.sampled_from(sorted(lattice.places))
    start, goal = data.draw(cells), data.draw(cells)
    path = lattice.path(start, goal)
    assert path is not None or lattice.columns == 1 or lattice.rows == 1
    steps: list[Cell] = [start, *(path or [])]
    assert all(lattice.graph.has_edge(a, b) for a, b in pairwise(steps))
    assert path is None or steps[-1] == goal


def test_a_blocked_arc_is_gone_around_and_what_is_cut_off_has_no_path() -> None:
    lattice = RigidGraph()
    neighbor = next(iter(lattice.graph[lattice.center]))
    assert lattice.path(lattice.center, neighbor) == [neighbor]
    lattice.block(lattice.center, neighbor)
    lattice.block(lattice.center, neighbor)
    around = lattice.path(lattice.center, neighbor)
    assert around is not None
    assert len(around) == 2
    for other in list(lattice.graph[neighbor]):
        lattice.block(neighbor, other)
    assert lattice.path(lattice.center, neighbor) is None


def test_even_lattices_and_unknown_strategies_are_refused() -> None:
    with pytest.raises(ValueError, match=r"odd rows and columns .* 4x5"):
        RigidGraph(4, 5)
    with pytest.raises(ValueError, match="unknown exploration strategy 'spiral'; known: rows, columns"):
        RigidGraph().order("spiral")


def test_the_lattice_is_a_hexagon_s() -> None:
    lattice = RigidGraph(spacing=0.05)
    x, y = lattice.places[(2, 3)]
    assert (x, y) == pytest.approx((0.05 * math.sqrt(0.75), 0.025))
