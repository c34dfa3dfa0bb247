from __future__ import annotations

import math

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.goals import FollowFrom, Leg
from tolman.agent.navigation.legs import legs_along
from tolman.maps.errors import MapError
from tolman.maps.hybrid_map import HybridMap

from .rings import QUARTER, SQUARE, ring


def plan_legs(graph: HybridMap, start: int, arrival: str, goal: int) -> tuple[Leg, ...]:
    """The legs of the shortest way."""
    return legs_along(graph, graph.path(start, goal), arrival)


def test_onward_it_follows_on_from_the_corner_it_stands_at() -> None:
    first, second = plan_legs(ring(SQUARE), 0, "right", 2)
    assert (first.source, first.target, first.side, first.corner) == (0, 1, "right", "concave")
    assert (first.turn, first.start) == (0.0, FollowFrom.CONCAVE)
    assert first.bend == pytest.approx(QUARTER)
    assert (second.source, second.target, second.turn, second.start) == (1, 2, 0.0, None)


def test_the_other_way_it_turns_around_first_and_keeps_the_other_hand() -> None:
    (leg,) = plan_legs(ring(SQUARE), 0, "right", 3)
    assert (leg.source, leg.target, leg.side) == (0, 3, "left")
    assert leg.turn == pytest.approx(math.pi)
    assert leg.start is FollowFrom.WALL


def test_at_a_convex_corner_the_wall_begins_a_little_ahead_after_turning_around() -> None:
    graph = ring(SQUARE, convex=0)
    (back,) = plan_legs(graph, 0, "right", 3)
    assert back.start is FollowFrom.GAP
    (onward,) = plan_legs(graph, 0, "right", 1)
    assert onward.start is FollowFrom.CONVEX
    assert onward.bend == pytest.approx(-QUARTER)


def test_who_came_by_the_other_side_goes_on_without_turning() -> None:
    (leg,) = plan_legs(ring(SQUARE), 0, "left", 3)
    assert leg.turn == 0.0
    assert leg.start is FollowFrom.CONCAVE


def test_no_way_is_an_error_and_no_distance_no_legs() -> None:
    graph = ring(SQUARE)
    assert plan_legs(graph, 2, "right", 2) == ()
    for side in ("right", "left"):
        for a, b in [(0, 1), (1, 0), (0, 3), (3, 0)]:
            if graph.graph.has_edge(a, b, side):
                graph.block(a, b, side)
    with pytest.raises(MapError, match="no way from node 0 to node 2"):
        plan_legs(graph, 0, "right", 2)


@given(st.lists(st.floats(0.1, 3.0), min_size=3, max_size=12), st.data())
def test_the_legs_are_a_shortest_way(lengths: list[float], data: st.DataObject) -> None:
    graph = ring(lengths)
    nodes = st.integers(0, len(lengths) - 1)
    start, goal = data.draw(nodes), data.draw(nodes)
    legs = plan_legs(graph, start, data.draw(st.sampled_from(["right", "left"])), goal)
    expected = nx.shortest_path_length(graph.graph, start, goal, weight="distance")
    assert sum(leg.distance for leg in legs) == pytest.approx(expected)
    places = [start, *(leg.target for leg in legs)]
    assert [leg.source for leg in legs] == places[:-1]
    assert places[-1] == goal
