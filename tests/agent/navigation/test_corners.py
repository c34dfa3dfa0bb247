from __future__ import annotations

from typing import Any

import pytest
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, Event, Lost, NodeReached
from tolman.agent.goals import GoAlong, LegDriven, PlacesDriven
from tolman.agent.navigation.corners import Navigator
from tolman.maps.hybrid_map import HybridMap
from tolman.plugins.testing import ScriptedRobot, event_of
from tolman.world.robot import Pose

from ..puppets import Puppet
from .rings import QUARTER, SQUARE, ring


class GoPuppet(Puppet):
    name = "go-to-node"
    Goal = GoAlong


def navigator(graph: HybridMap, node: int) -> tuple[Navigator, GoPuppet, Agent, list[Event]]:
    puppet = GoPuppet()
    agent, heard = Agent(ScriptedRobot(), [puppet]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    return Navigator(agent, graph, node), puppet, agent, heard


def finish(agent: Agent, behavior: str, succeeded: bool, result: Any, reason: str = "") -> None:
    agent.bus.publish(
        BehaviorFinished(time=1.0, behavior=behavior, succeeded=succeeded, reason=reason, result=result)
    )
    agent.tick()
    agent.tick()


def test_a_trip_onward_ends_in_the_transition_pose_without_a_last_turn() -> None:
    trip, puppet, agent, heard = navigator(ring(SQUARE), 0)
    trip.go(1)
    goal = puppet.goals[-1]
    assert isinstance(goal, GoAlong)
    assert goal.face == pytest.approx(0.0)
    assert trip.path == [0, 1]
    finish(agent, "go-to-node", True, (LegDriven(0, 1, "right", 1.0, True),))
    assert (trip.done, trip.reached, trip.node, trip.arrival) == (True, True, 1, "right")
    assert event_of(heard, NodeReached).node == 1


def test_a_trip_back_ends_with_the_turn_to_the_entry_heading() -> None:
    """In a square corner who comes along the other wall stands a quarter off, and faces the entry heading."""
    trip, puppet, agent, _ = navigator(ring(SQUARE), 0)
    trip.go(3)
    assert puppet.goals[-1].face == pytest.approx(QUARTER)
    finish(agent, "go-to-node", True, (LegDriven(0, 3, "left", 1.0, True),))
    assert (trip.node, trip.arrival) == (3, "right")


def test_a_trip_that_fails_says_where_it_was_last_and_that_it_is_lost() -> None:
    trip, _, agent, heard = navigator(ring(SQUARE), 0)
    trip.go(2)
    finish(agent, "go-to-node", False, (LegDriven(0, 1, "right", 1.0, True),), "no corner")
    assert (trip.done, trip.reached, trip.node, trip.reason) == (True, False, 1, "no corner")
    assert event_of(heard, Lost).reason == "no corner"


def test_where_there_is_no_way_nothing_is_started() -> None:
    graph = ring(SQUARE)
    graph.add_node()
    trip, puppet, _, _ = navigator(graph, 0)
    trip.go(4)
    assert (trip.done, trip.reached) == (True, False)
    assert "no way" in trip.reason
    assert not hasattr(puppet, "goals")


def test_what_another_behavior_finishes_does_not_end_a_trip() -> None:
    trip, _, agent, _ = navigator(ring(SQUARE), 0)
    trip.go(1)
    finish(agent, "local-go-to", True, PlacesDriven(1, Pose()))
    assert not trip.done
