from __future__ import annotations

import json
import math

import pytest
from tolman.agent.codec import decode, encode
from tolman.agent.islands.coverage import ScoutConfig, Scouting
from tolman.agent.islands.outlines import Outline
from tolman.agent.islands.sweep import Sweep
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta

from .rooms import ISLAND, QUARTER


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
    again = decode(json.loads(json.dumps(encode(scouting))), Scouting, ScoutConfig, Sweep, Outline)
    assert again == scouting
    assert again.next(found, 0) == scouting.next(found, 0)
