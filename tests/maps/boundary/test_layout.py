from __future__ import annotations

import math
from typing import Any

import pytest
from tolman.maps.boundary.layout import PLACE, layout, place_in
from tolman.maps.hybrid_map import HybridMap


@pytest.mark.parametrize(
    "note", [5, "ab", ["x", 1], [1.0], [math.nan, 0.0], [0.0, math.nan], [1e308, 0.0], [10**400, 0], {"x": 1}]
)
def test_a_note_that_is_no_place_is_none(note: Any) -> None:
    hybrid = HybridMap()
    hybrid.add_node(notes={PLACE: note})
    assert place_in(hybrid.graph.nodes[0]["notes"]) is None
    assert layout(hybrid) == {0: (0.0, 0.0)}


def test_a_part_lies_where_its_note_says_and_others_side_by_side() -> None:
    hybrid = HybridMap()
    for _ in range(2):
        hybrid.add_node()
    hybrid.add_node(notes={PLACE: [0.5, 2]})
    assert layout(hybrid) == {0: (0.0, 0.0), 1: (0.5, 0.0), 2: (0.5, 2.0)}
