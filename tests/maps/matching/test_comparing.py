from __future__ import annotations

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.maps.boundary.layout import PLACE, layout
from tolman.maps.boundary.walk import boundaries
from tolman.maps.errors import NoMatchError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.matching.comparing import compare
from tolman.maps.matching.frames import Frames
from tolman.maps.matching.merging import merge

from .rooms import Room, map_of, random_room

SQUARE = Room(("concave",) * 4, (0.9,) * 4, 5)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(
    room=st.integers(0, 500),
    starts=st.tuples(st.integers(0, 23), st.integers(0, 23)),
    sides=st.tuples(st.sampled_from(["right", "left"]), st.sampled_from(["right", "left"])),
)
def test_maps_of_one_room_match_from_any_start_and_side(
    room: int, starts: tuple[int, int], sides: tuple[str, str]
) -> None:
    one, true_one = map_of(random_room(room), starts[0], sides[0], seed=1)
    other, true_other = map_of(random_room(room), starts[1], sides[1], seed=2)
    found = compare(one, other)
    assert len(found.matched) == 24
    assert all(true_one[a] == true_other[b] for a, b in found.matched.items())


def test_nodes_missing_on_one_side_are_named_and_the_rest_still_matches() -> None:
    one, true_one = map_of(random_room(3), 0, seed=1, missing=(4, 5))
    other, true_other = map_of(random_room(3), 9, "left", seed=2, missing=(17,))
    found = compare(one, other)
    assert {true_one[node] for node in found.only_one} == {17}
    assert {true_other[node] for node in found.only_other} == {4, 5}
    assert all(true_one[a] == true_other[b] for a, b in found.matched.items())


def test_an_open_map_matches_the_part_it_has_seen() -> None:
    part, true_part = map_of(random_room(8), 0, seed=1, missing=tuple(range(16, 24)), closed=False)
    whole, true_whole = map_of(random_room(8), 0, "left", seed=2)
    found = compare(part, whole)
    assert len(found.matched) >= 14
    assert all(true_part[a] == true_whole[b] for a, b in found.matched.items())


@pytest.mark.parametrize("seed", range(6))
def test_maps_of_different_rooms_are_refused(seed: int) -> None:
    one, _ = map_of(random_room(seed))
    for other in (random_room(seed + 100), random_room(seed + 200, 10)):
        with pytest.raises(NoMatchError):
            compare(one, map_of(other)[0])


def test_a_symmetric_room_is_ambiguous_unless_its_views_differ() -> None:
    with pytest.raises(NoMatchError, match="in 4 ways"):
        compare(map_of(SQUARE)[0], map_of(SQUARE, 2, seed=3)[0])
    one, true_one = map_of(SQUARE, 0, views=True)
    for start, side in ((1, "right"), (2, "left"), (3, "left")):
        other, true_other = map_of(SQUARE, start, side, seed=3, views=True)
        matched = compare(one, other).matched
        assert {a: true_other[b] for a, b in matched.items()} == true_one


def test_maps_without_arcs_cannot_be_compared() -> None:
    with pytest.raises(NoMatchError, match="without a boundary"):
        compare(HybridMap(), HybridMap())


def test_arcs_that_differ_are_told_from_those_that_do_not() -> None:
    one, _ = map_of(random_room(3), noise=0.002, seed=1)
    other, _ = map_of(random_room(3), noise=0.002, seed=2)
    node = other.nodes()[7]
    for arc in [arc for arc in other.leaving(node) if arc.kind == "right"]:
        other.graph.edges[arc.start, arc.end, "right"]["distance"] += 0.05
    different = [arc for arc in compare(one, other).arcs if arc.differs]
    assert [arc.other[0] for arc in different] == [node]


def test_the_rotation_between_the_frames_is_found() -> None:
    one, _ = map_of(random_room(3), 0, seed=1)
    other, _ = map_of(random_room(3), 0, seed=1)
    for node in other.nodes():
        other.graph.nodes[node]["entry_heading"] += 0.7
    assert compare(one, other).rotation == pytest.approx(0.7)


def test_a_comparison_is_plain_json() -> None:
    one, _ = map_of(random_room(3), seed=1)
    assert json.loads(json.dumps(compare(one, one).to_json()))["matched"][0] == [0, 0]


@settings(max_examples=10, deadline=None, derandomize=True)
@given(
    room=st.integers(0, 300),
    sides=st.tuples(st.sampled_from(["right", "left"]), st.sampled_from(["right", "left"])),
    missing=st.tuples(st.sets(st.integers(0, 23), max_size=2), st.sets(st.integers(0, 23), max_size=2)),
)
def test_a_merged_map_has_each_corner_once_and_one_closed_boundary(
    room: int, sides: tuple[str, str], missing: tuple[set[int], set[int]]
) -> None:
    one, true_one = map_of(random_room(room), 3, sides[0], seed=1, missing=tuple(missing[0]))
    other, true_other = map_of(random_room(room), 11, sides[1], seed=2, missing=tuple(missing[1]))
    merged = merge(one, other)
    known = {*true_one.values(), *true_other.values()}
    assert len(merged.graph) == len(known)
    (boundary,) = boundaries(merged)
    assert boundary.closed
    assert len(boundary) == len(known)
    assert len(list(merged.arcs())) == 2 * len(known)
    convex = sum(kind == "convex" for kind in boundary.corners)
    turned = sum(boundary.turns)
    assert turned == pytest.approx((len(known) - 2 * convex) * math.pi / 2, abs=1.0)


@pytest.mark.parametrize("sides", [("right", "right"), ("right", "left"), ("left", "right")])
@pytest.mark.parametrize("corner", [4, 9, 23])
def test_neighbors_of_which_each_map_lacks_one_are_joined_at_their_distance(
    corner: int, sides: tuple[str, str]
) -> None:
    room = random_room(3)
    one, true_one = map_of(room, 3, sides[0], seed=1, missing=(corner,), noise=0.002)
    other, true_other = map_of(room, 11, sides[1], seed=2, missing=((corner + 1) % 24,), noise=0.002)
    found = compare(one, other)
    merged = merge(one, other, found)
    true = {**true_one}
    for partner, node in zip(found.only_other, range(len(one.graph), len(merged.graph)), strict=True):
        true[node] = true_other[partner]
    numbers = {place: node for node, place in true.items()}
    assert sorted(numbers) == list(range(24))
    for place in range(24):
        there, back = numbers[place], numbers[(place + 1) % 24]
        assert merged.arc(there, back, "right").distance == pytest.approx(room.lengths[place], abs=0.02)
        assert merged.arc(back, there, "left").distance == pytest.approx(room.lengths[place], abs=0.02)
    assert len(list(merged.arcs())) == 48


def test_merged_arcs_pool_what_both_measured() -> None:
    one, _ = map_of(random_room(3), noise=0.0, seed=1)
    other, _ = map_of(random_room(3), noise=0.0, seed=2)
    before = one.arc(0, 1, "right")
    other.record_traversal(0, 1, "right", before.distance + 0.03)
    pooled = merge(one, other).arc(0, 1, "right")
    assert pooled.traversals == 3
    assert pooled.distance == pytest.approx(before.distance + 0.01)
    assert pooled.variance > before.variance


def test_merging_leaves_both_maps_as_they_were() -> None:
    one, _ = map_of(random_room(3), seed=1, missing=(4,))
    other, _ = map_of(random_room(3), seed=2)
    before = [list(one.arcs()), list(other.arcs()), one.nodes(), other.nodes()]
    merge(one, other)
    assert [list(one.arcs()), list(other.arcs()), one.nodes(), other.nodes()] == before


def add_block(hybrid: HybridMap, place: tuple[float, float], heading: float) -> list[int]:
    """A square block that a foray from node 0 has found; its four nodes. place, heading: of the first one."""
    turn = -math.pi / 2 if hybrid.meta.side == "right" else math.pi / 2
    nodes = [
        hybrid.add_node(corner="convex", turn=turn, entry_heading=heading + index * turn)
        for index in range(4)
    ]
    for index, node in enumerate(nodes):
        hybrid.add_arc(node, nodes[(index + 1) % 4], hybrid.meta.side, 0.25)
    hybrid.annotate(nodes[0], **{PLACE: [*place]})
    notes = {"crossing": {"turn": 1}}
    hybrid.add_arc(0, nodes[0], hybrid.meta.side, 0.5, kind="foray", both_ways=False, notes=notes)
    return nodes


def two_maps_with_a_block(sides: tuple[str, str]) -> tuple[HybridMap, HybridMap, list[int], list[int]]:
    """Both know the block, each from another of its corners on."""
    one, _ = map_of(random_room(3), 0, sides[0], seed=1)
    other, _ = map_of(random_room(3), 7, sides[1], seed=2)
    found = compare(one, other)
    back = Frames(other, one, {b: a for a, b in found.matched.items()}, -found.rotation)
    first = add_block(one, (0.5, 0.6), 0.2)
    places = layout(one)
    start = 2 if sides[0] == sides[1] else 3
    x, y = back.moved(places[first[start]])
    heading = one.graph.nodes[first[start]]["entry_heading"] + found.rotation
    if sides[0] != sides[1]:
        heading += one.graph.nodes[first[start]]["turn"] + math.pi
    return one, other, first, add_block(other, (x + 0.03, y - 0.02), heading)


@pytest.mark.parametrize("sides", [("right", "right"), ("right", "left"), ("left", "right")])
def test_a_block_that_matches_in_four_ways_is_matched_by_its_place(sides: tuple[str, str]) -> None:
    one, other, first, second = two_maps_with_a_block(sides)
    found = compare(one, other)
    assert len(found.matched) == 28
    expected = [(2 + index) % 4 for index in range(4)] if sides[0] == sides[1] else [3, 2, 1, 0]
    assert [found.matched[first[corner]] for corner in expected] == second
    merged = merge(one, other, found)
    assert len(merged.graph) == 28
    assert len(boundaries(merged)) == 2


def test_a_block_of_the_other_map_is_added_at_its_place_in_the_one_frame() -> None:
    one, other, first, second = two_maps_with_a_block(("right", "right"))
    expected = layout(one)
    for node in first:
        one.remove_node(node)
    found = compare(one, other)
    assert set(found.only_other) == set(second)
    merged = merge(one, other, found)
    places = layout(merged)
    added = [node for node in merged.nodes() if node not in one.graph]
    for node, corner in zip(added, [2, 3, 0, 1], strict=True):
        assert math.dist(places[node], expected[first[corner]]) < 0.08
    forays = [arc for arc in merged.arcs() if arc.kind == "foray"]
    assert [arc.end for arc in forays] == [added[0]]
    assert forays[0].notes == {"crossing": {"turn": 1}}


def test_forays_of_a_map_made_along_the_other_side_are_left_out() -> None:
    one, other, first, _ = two_maps_with_a_block(("right", "left"))
    forays = [arc for arc in merge(one, other).arcs() if arc.kind == "foray"]
    assert [(arc.start, arc.end) for arc in forays] == [(0, first[0])]
