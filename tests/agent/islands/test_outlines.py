from __future__ import annotations

import math

import pytest
from tolman.agent.islands.outlines import (
    closed_points,
    first_hit,
    outline_from,
    outlines,
)
from tolman.maps.boundary.layout import PLACE
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.world.robot import Pose

from .rooms import ISLAND, QUARTER, ROOM


def rectangle(
    found: HybridMap, width: float, depth: float, turn: float, kind: str, heading: float
) -> list[int]:
    nodes = []
    for corner in range(4):
        nodes.append(found.add_node(corner=kind, turn=turn, entry_heading=heading + corner * turn))
    for corner, length in enumerate((width, depth, width, depth)):
        found.add_arc(nodes[corner], nodes[(corner + 1) % 4], "right", length)
    return nodes


def test_a_boundary_is_laid_out_from_its_turns_and_lengths() -> None:
    found = HybridMap(MapMeta(side="right"))
    rectangle(found, 1.2, 1.0, QUARTER, "concave", 0.0)
    outline = outline_from(found, 0)
    assert outline is not None
    assert outline.nodes == (0, 1, 2, 3)
    assert outline.points[2] == pytest.approx((-1.0, 1.2))
    assert outline.turning == 1.0


def test_what_is_missing_when_it_comes_round_is_spread_out() -> None:
    turns = [QUARTER + 0.02, QUARTER - 0.01, QUARTER, QUARTER + 0.01]
    points = closed_points(["concave"] * 4, turns, [1.0, 0.52, 1.0, 0.50], Pose())
    assert math.dist(points[1], (0.0, 1.0)) < 0.02
    assert math.dist(points[3], (-0.5, 0.0)) < 0.02


def test_islands_lie_where_their_first_node_is_noted_to_be() -> None:
    found = HybridMap(MapMeta(side="right"))
    rectangle(found, 1.2, 1.0, QUARTER, "concave", -QUARTER)
    first = rectangle(found, 0.2, 0.4, -QUARTER, "convex", math.pi)[0]
    assert len(outlines(found)) == 1
    found.annotate(first, **{PLACE: [0.4, 0.4]})
    room, island = outlines(found)
    assert (room.turning, island.turning) == (1.0, -1.0)
    assert island.points[0] == pytest.approx((0.4, 0.4))
    assert island.points[1] == pytest.approx((0.4, 0.6))


def test_an_open_boundary_has_no_outline() -> None:
    found = HybridMap(MapMeta(side="right"))
    rectangle(found, 1.2, 1.0, QUARTER, "concave", 0.0)
    found.remove_arc(3, 0, "right")
    assert outline_from(found, 0) is None
    assert outlines(found) == []


def test_a_straight_way_ends_at_the_first_wall() -> None:
    hit = first_hit([ROOM, ISLAND], 0.6, 0.0, QUARTER)
    assert hit is not None
    distance, mark = hit
    assert distance == pytest.approx(0.4)
    assert (mark.outline, mark.edge) == (1, 3)
    assert mark.along == pytest.approx(0.2)
    assert first_hit([ISLAND], 0.6, 0.0, -QUARTER) is None
