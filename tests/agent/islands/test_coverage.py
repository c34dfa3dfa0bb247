from __future__ import annotations

import math

import pytest
from tolman.agent.islands.coverage import ScoutConfig, Scouting, best_link, node_at, nodes_near, pose_at
from tolman.agent.islands.outlines import Outline
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.world.robot import Pose

QUARTER = 0.5 * math.pi
ROOM = Outline(((0.0, 0.0), (1.2, 0.0), (1.2, 1.0), (0.0, 1.0)), (0, 1, 2, 3), ("concave",) * 4)
ISLAND = Outline(((0.4, 0.4), (0.4, 0.6), (0.8, 0.6), (0.8, 0.4)), (4, 5, 6, 7), ("convex",) * 4)


def room() -> HybridMap:
    found = HybridMap(MapMeta(side="right"))
    for corner in range(4):
        found.add_node(corner="concave", turn=QUARTER, entry_heading=corner * QUARTER)
    for corner, length in enumerate((1.2, 1.0, 1.2, 1.0)):
        found.add_arc(corner, (corner + 1) % 4, "right", length)
    return found


def test_lines_are_driven_one_after_the_other_until_all_is_covered() -> None:
    found = room()
    scouting = Scouting.over(found, ScoutConfig(spacing=0.35))
    node, lines = 0, set()
    while (chord := scouting.next(found, node)) is not None:
        known = scouting.all(found)
        crossing, pose = scouting.crossing(known, chord)
        assert crossing.distance == pytest.approx(1.0)
        assert abs(crossing.turn) == pytest.approx(QUARTER)
        assert known[0].distance(pose.x, pose.y) < 1e-9
        lines.add(chord.line)
        end = pose.compose(0.0, 0.0)
        heading = scouting.sweep.heading(chord)
        x, y = end.x + math.cos(heading), end.y + math.sin(heading)
        assert scouting.is_known(known, x, y, 1.0)
        assert not scouting.is_known(
            known, end.x + 0.5 * math.cos(heading), end.y + 0.5 * math.sin(heading), 0.5
        )
        scouting.drove(chord, x, y)
        node = known[0].nodes[chord.start.edge]
    assert lines == {0, 1, 2}


def test_a_line_that_fails_is_not_tried_for_ever() -> None:
    found = room()
    scouting = Scouting.over(found, ScoutConfig(spacing=0.35, tries=2))
    tries = 0
    while (chord := scouting.next(found, 0)) is not None:
        scouting.try_once(chord)
        tries += 1
    assert tries == 3 * 2 * 2


def test_it_goes_on_from_what_was_kept_as_from_what_was_known() -> None:
    found = room()
    scouting = Scouting.over(found, ScoutConfig())
    chord = scouting.next(found, 0)
    assert chord is not None
    scouting.try_once(chord)
    scouting.drove(chord, 0.1, 0.2)
    scouting.blind.append(ISLAND)
    again = Scouting.restored(scouting.state(), ScoutConfig())
    assert again.state() == scouting.state()
    assert again.next(found, 0) == scouting.next(found, 0)


def test_a_corner_is_the_node_that_is_there_and_stands_as_its_wall_does() -> None:
    assert node_at([ROOM, ISLAND], Pose(0.42, 0.62, QUARTER), "convex", 0.1) == 5
    assert node_at([ROOM, ISLAND], Pose(0.42, 0.62, 0.0), "convex", 0.1) is None
    assert node_at([ROOM, ISLAND], Pose(0.42, 0.62, QUARTER), "concave", 0.1) is None


def test_which_of_two_near_corners_it_is_is_left_open() -> None:
    twin = Outline(tuple((x + 0.06, y) for x, y in ISLAND.points), (8, 9, 10, 11), ISLAND.corners)
    corner = Pose(0.43, 0.6, QUARTER)
    assert set(nodes_near([ISLAND, twin], corner, "convex", 0.1)) == {5, 9}
    assert node_at([ISLAND, twin], corner, "convex", 0.1) is None


def test_a_node_is_reached_along_the_wall_before_it_or_back_along_the_one_after() -> None:
    there, back = pose_at([ISLAND], 5, False), pose_at([ISLAND], 5, True)
    assert there is not None
    assert back is not None
    assert (there.x, there.y, there.heading) == pytest.approx((0.4, 0.6, QUARTER))
    assert back.heading == pytest.approx(math.pi)
    assert pose_at([ISLAND], 99, False) is None


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
