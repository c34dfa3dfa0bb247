from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray
from tolman.agent.localization.views import NodeViews
from tolman.maps.errors import MapFileDamagedError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta
from tolman.world.robot import EPUCK

from ..sceneries import panorama

FIELD = EPUCK.camera_field_of_view


def map_with(views: Mapping[int, NDArray[np.float32] | None]) -> HybridMap:
    """Nodes with these panoramas of their entry."""
    found = HybridMap(MapMeta(side="right"))
    for view in views.values():
        node = found.add_node(corner="concave")
        if view is not None:
            local_map = LocalMap.build(np.zeros((1, 2)), entry_panorama=view)
            found.graph.nodes[node]["local_map"] = local_map
    return found


def test_a_view_speaks_against_all_nodes_that_look_different() -> None:
    views = NodeViews(map_with({node: panorama(node) for node in range(4)}), FIELD)
    for node in range(4):
        says = views.against(panorama(node, turned=0.02), range(4))
        assert says.pop(node) == 0.0
        assert max(says.values()) < -8.0


def test_it_says_nothing_of_nodes_that_look_alike() -> None:
    views = NodeViews(map_with({0: panorama(3), 1: panorama(3, turned=0.01), 2: panorama(4)}), FIELD)
    assert not views.any_apart([(0, 1)])
    assert views.any_apart([(0, 1), (1, 2)])
    says = views.against(panorama(3, turned=-0.01), [0, 1, 2])
    assert (says[0], says[1]) == (0.0, 0.0)
    assert says[2] < -8.0


def test_a_view_of_something_else_says_nothing() -> None:
    views = NodeViews(map_with({0: panorama(0), 1: panorama(1)}), FIELD)
    assert views.against(panorama(9), [0, 1]) == {}


def test_nodes_without_views_are_neither_told_apart_nor_spoken_against() -> None:
    views = NodeViews(map_with({0: panorama(0), 1: None}), FIELD)
    assert not views.any_apart([(0, 1)])
    assert views.against(panorama(0), [0, 1]) == {0: 0.0, 1: 0.0}
    assert views.against(panorama(0), [1]) == {}


def test_a_damaged_local_map_counts_as_none() -> None:
    def damaged() -> None:
        raise MapFileDamagedError("x.tolman: node 1: the local map is damaged")

    found = map_with({0: panorama(0), 1: panorama(1)})
    found.graph.nodes[1]["local_map"] = LocalMap(damaged)  # type: ignore[arg-type]
    views = NodeViews(found, FIELD)
    assert not views.any_apart([(0, 1)])
    assert views.against(panorama(0), [0, 1]) == {0: 0.0, 1: 0.0}


@pytest.mark.parametrize("width", [8, 32])
def test_views_of_another_size_say_nothing(width: int) -> None:
    views = NodeViews(map_with({0: panorama(0), 1: panorama(1)}), FIELD)
    assert views.against(panorama(0, width=width), [0, 1]) == {}
