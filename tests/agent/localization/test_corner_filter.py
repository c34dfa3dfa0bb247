from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent.localization.corner_filter import BoundaryFilter
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta

QUARTER = 0.5 * math.pi
ROOM = [("concave", 0.54), ("concave", 0.30), ("convex", 0.34), ("concave", 0.58), ("concave", 0.88)]
ROOM += [("concave", 0.19), ("concave", 0.53), ("convex", 0.23), ("convex", 0.53), ("concave", 0.47)]
"""Corners of env1 and the length of the arc that leaves each (m)."""


def room(corners: list[tuple[str, float]]) -> HybridMap:
    found = HybridMap(MapMeta(side="right"))
    for kind, _ in corners:
        found.add_node(corner=kind, turn=QUARTER if kind == "concave" else -QUARTER)
    for node, (_, length) in enumerate(corners):
        found.add_arc(node, (node + 1) % len(corners), "right", length)
    return found


def walk(
    found: BoundaryFilter, corners: list[tuple[str, float]], start: int, count: int, rng: np.random.Generator
) -> int | None:
    """Passes `count` corners from `start` on until the filter is sure; returns where it truly is."""
    first = corners[start - 1][1] * rng.uniform(0.05, 0.95)
    found.corner(corners[start][0], first)
    for step in range(count):
        if found.estimate is not None:
            return (start + step) % len(corners)
        here = (start + step) % len(corners)
        kind, length = corners[here]
        found.turned((QUARTER if kind == "concave" else -QUARTER) + rng.normal(0, 0.02))
        after = corners[(here + 1) % len(corners)][0]
        found.corner(after, length + rng.normal(0, 0.002 + 0.003 * length))
    return (start + count) % len(corners)


@pytest.mark.parametrize("start", range(len(ROOM)))
def test_finds_its_place_from_every_corner_within_half_a_loop(start: int) -> None:
    for seed in range(20):
        found = BoundaryFilter(room(ROOM))
        truth = walk(found, ROOM, start, 12, np.random.default_rng(seed))
        assert found.estimate == truth
        assert found.length < 0.62 * found.loop_length


@given(seed=st.integers(0, 10_000), sides=st.integers(2, 4))
@settings(max_examples=60)
def test_never_settles_on_a_place_in_a_room_that_repeats_itself(seed: int, sides: int) -> None:
    rng = np.random.default_rng(seed)
    part = [("concave", float(rng.uniform(0.2, 0.9))) for _ in range(2)]
    corners = part * sides
    found = BoundaryFilter(room(corners))
    start = int(rng.integers(len(corners)))
    walk(found, corners, start, 3 * len(corners), rng)
    assert found.estimate is None
    assert len(found.hypotheses) >= sides


def test_does_not_settle_on_a_place_in_another_room() -> None:
    other = [("concave", 0.71), ("concave", 0.41), ("concave", 0.71), ("concave", 0.41)]
    found = BoundaryFilter(room(ROOM))
    walk(found, other, 0, 12, np.random.default_rng(3))
    assert found.estimate is None


def test_finds_back_after_a_stretch_of_wall_that_has_changed() -> None:
    rng = np.random.default_rng(5)
    found = BoundaryFilter(room(ROOM))
    found.corner("concave", 0.2)
    for kind, length in [("concave", 0.11), ("convex", 0.24), ("concave", 0.33)]:
        found.corner(kind, length)
    settled: list[tuple[int, int | None]] = []
    for node in range(4, 10):
        found.corner(ROOM[(node + 1) % 10][0], ROOM[node][1] + rng.normal(0, 0.002))
        settled.append(((node + 1) % 10, found.estimate))
    assert settled[-1][1] == settled[-1][0]
    assert all(estimate in (None, truth) for truth, estimate in settled)


def test_one_arc_is_not_enough_to_settle_on_a_place() -> None:
    found = BoundaryFilter(room([("concave", 0.9), ("convex", 0.2), ("concave", 0.4), ("concave", 0.6)]))
    found.corner("concave", 0.3)
    found.corner("convex", 0.9)
    assert found.estimate is None


SQUARE = [("concave", 0.9)] * 4


def look(found: BoundaryFilter, truth: int, apart: float = 9.0) -> None:
    """A look around at a corner that is unlike every other node's by `apart` nats."""
    found.seen({node: 0.0 if node == truth else -apart for node in found.likely})


@pytest.mark.parametrize("start", range(4))
def test_views_tell_where_it_is_in_a_room_that_repeats_itself(start: int) -> None:
    found = BoundaryFilter(room(SQUARE))
    found.corner("concave", 0.4)
    assert len(found.contested) == 6
    look(found, start)
    assert found.estimate is None
    found.turned(QUARTER)
    found.corner("concave", 0.901)
    look(found, (start + 1) % 4)
    assert found.estimate == (start + 1) % 4
    assert found.contested == []


def test_a_single_look_is_never_enough() -> None:
    found = BoundaryFilter(room(SQUARE))
    found.corner("concave", 0.4)
    look(found, 0, apart=1000.0)
    for _ in range(3):
        found.turned(QUARTER)
        found.corner("concave", 0.9)
        found.seen({})
    assert found.estimate is None


def test_views_do_not_outweigh_a_boundary_that_fits_nowhere_else() -> None:
    found = BoundaryFilter(room(ROOM))
    found.corner("concave", 0.2)
    found.seen({node: 0.0 if node == 8 else -1000.0 for node in found.likely})
    rng = np.random.default_rng(2)
    for node in range(4):
        found.turned(QUARTER if ROOM[node][0] == "concave" else -QUARTER)
        found.corner(ROOM[node + 1][0], ROOM[node][1] + rng.normal(0, 0.002))
        assert found.estimate in (None, node + 1)
    assert found.estimate == 4


def test_where_the_boundary_decides_soon_nothing_is_contested() -> None:
    found = BoundaryFilter(room(ROOM))
    found.corner("concave", 0.2)
    assert found.contested == []
