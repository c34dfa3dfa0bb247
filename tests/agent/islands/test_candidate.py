from __future__ import annotations

from tolman.agent.codec import decode, encode
from tolman.agent.events import CornerReached
from tolman.agent.islands.candidate import Candidate
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.world.robot import Pose

from .rooms import QUARTER, ROOM


def room() -> HybridMap:
    found = HybridMap(MapMeta(side="right"))
    for node in range(4):
        found.add_node(corner="concave", turn=QUARTER, entry_heading=node * QUARTER)
    for node, length in enumerate((1.2, 1.0, 1.2, 1.0)):
        found.add_arc(node, (node + 1) % 4, "right", length)
    return found


def met(length: float) -> CornerReached:
    return CornerReached(
        time=0.0, side="right", kind="concave", path_length=length, heading=0.0, turn=QUARTER
    )


def test_two_known_corners_an_arc_apart_tell_where_it_is() -> None:
    candidate, found = Candidate(), room()
    assert candidate.known_as(found, [ROOM], Pose(1.1, 0.1, 0.0), met(0.7)) is None
    assert candidate.known_as(found, [ROOM], Pose(1.1, 1.1, QUARTER), met(1.01)) == 2


def test_corners_at_another_distance_are_of_something_else() -> None:
    candidate, found = Candidate(), room()
    candidate.known_as(found, [ROOM], Pose(1.1, 0.1, 0.0), met(0.7))
    assert candidate.known_as(found, [ROOM], Pose(1.1, 1.1, QUARTER), met(0.8)) is None


def test_its_track_has_places_apart_and_it_goes_on_from_what_was_kept() -> None:
    candidate = Candidate(first=4, place=Pose(0.4, 0.4, 1.0), maybe=[1, 2])
    for step in range(10):
        candidate.follow(Pose(0.01 * step, 0.0, 0.0), 0.1)
    assert candidate.track == [(0.0, 0.0), (0.05, 0.0)]
    assert decode(encode(candidate), Candidate) == candidate
