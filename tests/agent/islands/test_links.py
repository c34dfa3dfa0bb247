from __future__ import annotations

import pytest
from tolman.agent.islands.links import best_link

from .rooms import ISLAND, ROOM


def test_links_lead_from_wall_to_wall_and_to_a_corner() -> None:
    into = best_link([ROOM, ISLAND], [0], [1], "right")
    away = best_link([ROOM, ISLAND], [1], [0], "right")
    assert into is not None
    assert away is not None
    assert into.start in ROOM.nodes
    assert into.end in ISLAND.nodes
    assert into.crossing.distance == pytest.approx(0.4)
    assert (away.start in ISLAND.nodes, away.end in ROOM.nodes) == (True, True)


def test_a_link_that_failed_is_not_proposed_again() -> None:
    first = best_link([ROOM, ISLAND], [0], [1], "right")
    assert first is not None
    second = best_link([ROOM, ISLAND], [0], [1], "right", {(first.start, first.end)})
    assert second is not None
    assert (second.start, second.end) != (first.start, first.end)
