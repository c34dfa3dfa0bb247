from __future__ import annotations

import math

import pytest
from tolman.agent.estimation.odometry import PathIntegrator
from tolman.agent.events import CornerReached
from tolman.agent.islands.anchor import Anchor, node_at, nodes_near, pose_at
from tolman.agent.islands.outlines import Outline
from tolman.world.robot import EPUCK, Pose

from .rooms import ISLAND, QUARTER, ROOM


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


def corner(heading: float, kind: str = "concave", side: str = "right") -> CornerReached:
    return CornerReached(time=0.0, side=side, kind=kind, path_length=1.0, heading=heading, turn=QUARTER)


def test_at_a_node_path_integration_goes_on_from_there_turned_as_it_was_seen_to_be() -> None:
    odometry = PathIntegrator(EPUCK, Pose(1.15, 0.03, 0.3))
    anchor = Anchor(odometry, "right", near=0.045, near_slope=0.035)
    anchor.meet(corner(heading=0.2))
    anchor.meet(corner(heading=0.9, kind="bend"))
    assert anchor.node_at([ROOM], corner(heading=0.2)) == 1
    anchor.fix([ROOM], 1)
    assert (odometry.x, odometry.y) == (1.2, 0.0)
    assert odometry.heading == pytest.approx(0.1)
    assert anchor.corner is not None
    assert anchor.corner.heading == 0.0


def test_without_a_corner_met_path_integration_is_left_as_it_is() -> None:
    odometry = PathIntegrator(EPUCK, Pose(1.15, 0.03, 0.3))
    Anchor(odometry, "right", near=0.045, near_slope=0.035).fix([ROOM], 1)
    assert odometry.pose == Pose(1.15, 0.03, 0.3)
