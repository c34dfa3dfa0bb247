from __future__ import annotations

from typing import Any

import pytest
from tolman.agent import Agent
from tolman.agent.events import Stuck
from tolman.agent.goals import LegDriven
from tolman.agent.localization.localizer import Localizer
from tolman.agent.navigation.corners import Navigator
from tolman.agent.navigation.recovery import RecoveringNavigator
from tolman.behaviors.go_to_node import GoToNode
from tolman.behaviors.wall_following import WallFollowing
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.plugins.testing import ScriptedRobot, percept
from tolman.world.robot import Pose


def square() -> HybridMap:
    """Four concave corners, a meter apart, mapped by the right side."""
    found = HybridMap(MapMeta(side="right"))
    for _ in range(4):
        found.add_node(corner="concave", turn=1.5708)
    for node in range(4):
        found.add_arc(node, (node + 1) % 4, "right", 1.0)
    return found


@pytest.fixture
def guide() -> RecoveringNavigator:
    """At node 0 of the square, on a robot with a wall at its right for ever."""
    agent = Agent(ScriptedRobot([percept(right=0.022)]), [GoToNode(), WallFollowing()])
    hybrid_map = square()
    return RecoveringNavigator(agent, hybrid_map, Navigator(agent, hybrid_map, 0))


def drive(guide: RecoveringNavigator, ticks: int) -> None:
    for _ in range(ticks):
        guide.agent.tick()


def move(guide: RecoveringNavigator, distance: float) -> None:
    """Something else drives the robot."""
    pose = guide.agent.odometry.pose
    guide.agent.odometry.reset(Pose(pose.x + distance, pose.y, pose.heading))


def test_it_stands_where_the_navigator_stands_until_something_moves_it(guide: RecoveringNavigator) -> None:
    assert guide.node == 0
    move(guide, 0.02)
    assert guide.node is None
    guide.stand_at(3)
    assert guide.node == 3


def test_a_trip_cancelled_before_the_robot_moved_leaves_it_where_it_was(guide: RecoveringNavigator) -> None:
    guide.go(2)
    guide.stop()
    assert (guide.done, guide.reached, guide.reason, guide.node) == (True, False, "cancelled", 0)
    assert not guide.agent.is_active("go-to-node")


def test_cancelled_on_an_arc_it_knows_which_corner_it_meets_next(guide: RecoveringNavigator) -> None:
    guide.go(1)
    drive(guide, 400)
    guide.stop()
    assert (guide.node, guide.near) == (None, (1,))
    move(guide, 0.2)
    assert guide.near == ()


def test_it_finds_out_where_it_is_before_it_sets_out(guide: RecoveringNavigator) -> None:
    guide.lose()
    guide.go(2)
    assert guide.agent.is_active("wall-following")
    assert not guide.agent.is_active("go-to-node")
    guide.stop()
    assert not guide.agent.is_active("wall-following")


def test_where_nothing_can_be_found_out_it_says_so() -> None:
    agent, hybrid_map = Agent(ScriptedRobot(), [GoToNode()]), square()
    guide = RecoveringNavigator(agent, hybrid_map, Navigator(agent, hybrid_map, 0), localizes=False)
    guide.lose()
    guide.go(2)
    assert guide.done
    assert "has no way to find out" in guide.reason


def test_a_stuck_robot_ends_its_trip(guide: RecoveringNavigator) -> None:
    guide.go(2)
    drive(guide, 3)
    guide.agent.bus.publish(Stuck(time=0.0, reason="held", given_up=True))
    drive(guide, 2)
    assert (guide.done, guide.reached, guide.reason) == (True, False, "stuck")


def test_a_trip_that_never_ends_is_given_up(guide: RecoveringNavigator) -> None:
    guide.go(1)
    guide.agent.context.time = 1e6
    guide.update(percept(right=0.022), guide.agent.context)
    assert guide.reason == "not at node 1 in time"


def test_an_arc_that_cannot_be_driven_is_blocked_and_another_way_looked_for(
    guide: RecoveringNavigator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tolman.agent.navigation.recovery.Localizer", FoundAt0)
    guide.go(1)
    navigator: Any = guide.navigator
    assert [leg.side for leg in navigator.planned] == ["right"]
    navigator.finish(False, reason="no corner came")
    drive(guide, 3)
    assert guide.blocked == [(0, 1, "right"), (1, 0, "left")]
    assert [leg.side for leg in navigator.planned] == ["left", "left", "left"]
    navigator.legs = [LegDriven(leg.source, leg.target, leg.side, 1.0, True) for leg in navigator.planned]
    navigator.finish(True, 1, "arrived")
    assert (guide.done, guide.reached, len(guide.legs)) == (True, True, 3)


class FoundAt0(Localizer):
    """A localizer that knows at once."""

    def start(self) -> None:
        self.finish(True, 0, "localized")
