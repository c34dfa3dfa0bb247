from __future__ import annotations

import math

import pytest
from tolman.maps.boundary.walk import boundaries, close_polygon, onward, walk
from tolman.maps.hybrid_map import HybridMap

LOOP_WITH_A_LEAD_IN = {9: (0, 0.5), 0: (1, 0.25), 1: (2, 0.125), 2: (0, 1.0)}


def test_a_walk_round_a_closed_boundary_ends_where_it_began() -> None:
    way = walk(LOOP_WITH_A_LEAD_IN, 1)
    assert (way.nodes, way.end, way.closed) == ((1, 2, 0), 1, True)
    assert way.length == 1.375


def test_a_walk_that_leads_into_a_loop_is_not_closed() -> None:
    way = walk(LOOP_WITH_A_LEAD_IN, 9)
    assert (way.nodes, way.lengths, way.end, way.closed) == ((9, 0, 1, 2), (0.5, 0.25, 0.125, 1.0), 0, False)


def test_a_walk_ends_at_a_node_without_an_arc_onward_and_before_those_it_shall_stop_at() -> None:
    dead_end = walk({0: (1, 0.5)}, 0)
    assert (dead_end.nodes, dead_end.lengths, dead_end.end) == ((0, 1), (0.5,), None)
    stopped = walk(LOOP_WITH_A_LEAD_IN, 9, stop={2})
    assert (stopped.nodes, stopped.end) == ((9, 0, 1), 2)


def test_a_node_joined_to_itself_is_a_closed_boundary() -> None:
    hybrid = HybridMap()
    hybrid.add_arc(hybrid.add_node(), 0, "right", 0.44)
    (pillar,) = boundaries(hybrid)
    assert (pillar.nodes, pillar.lengths, pillar.closed) == ((0,), (0.44,), True)


def test_an_open_boundary_begins_where_nothing_leads_to() -> None:
    hybrid = HybridMap()
    for _ in range(4):
        hybrid.add_node(corner="concave", turn=0.5)
    for start, end in ((2, 0), (0, 3)):
        hybrid.add_arc(start, end, "right", 0.5)
    (open_one,) = boundaries(hybrid)
    assert (open_one.nodes, open_one.lengths, open_one.closed) == ((2, 0, 3), (0.5, 0.5, 0.0), False)
    assert onward(hybrid, "left") == {0: (2, 0.5), 3: (0, 0.5)}


def test_the_length_between_two_nodes_of_a_closed_boundary_goes_on_past_the_first() -> None:
    hybrid = HybridMap()
    for index in range(3):
        hybrid.add_node(node=index)
    for index, length in enumerate((0.25, 0.5, 1.0)):
        hybrid.add_arc(index, (index + 1) % 3, "right", length)
    (ring,) = boundaries(hybrid)
    assert ring.between(2, 4) == 1.25
    assert ring.between(1, 1) == 0.0


def test_closing_a_polygon_spreads_what_is_missing_over_its_edges_by_length() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    closed = close_polygon(points, (1.0, 1.0, 1.0, 1.0), (0.4, -0.4), 4.0)
    assert closed[0] == (0.0, 0.0)
    assert closed[2] == pytest.approx((0.8, 1.2))
    sides = [math.dist(closed[i], closed[i + 1]) for i in range(3)]
    assert max(sides) - min(sides) < 0.25
