from __future__ import annotations

import math
from enum import Enum
from typing import Any

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent import Agent
from tolman.agent.behavior import Behavior, Context, Proposal
from tolman.agent.events import BehaviorFinished, Event, Lost, NodeReached
from tolman.agent.goals import FollowFrom, GoAlong, LegDriven, PlacesDriven
from tolman.agent.navigation.corners import Navigator, plan_legs
from tolman.maps.errors import MapError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.plugins.testing import ScriptedRobot, event_of
from tolman.world.robot import Percept, Pose

QUARTER = 0.5 * math.pi


class Idle(Enum):
    IDLE = "idle"


class Puppet(Behavior):
    """Proposes nothing; keeps the goals it was given."""

    States, initial = Idle, Idle.IDLE
    goals: list[Any]

    def on_start(self, goal: Any, context: Context) -> None:
        self.goals = [*getattr(self, "goals", []), goal]

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        return None


class GoPuppet(Puppet):
    name = "go-to-node"


def ring(lengths: list[float], convex: int | None = None) -> HybridMap:
    """A right-side map of a loop with these arcs; node `convex` is a convex corner."""
    found = HybridMap(MapMeta(side="right"))
    for node in range(len(lengths)):
        bent = node == convex
        found.add_node(corner="convex" if bent else "concave", turn=-QUARTER if bent else QUARTER)
    for node, length in enumerate(lengths):
        found.add_arc(node, (node + 1) % len(lengths), "right", length)
    return found


SQUARE = [1.0, 1.0, 1.0, 1.0]


def test_onward_it_follows_on_from_the_corner_it_stands_at() -> None:
    first, second = plan_legs(ring(SQUARE), 0, "right", 2)
    assert (first.source, first.target, first.side, first.corner) == (0, 1, "right", "concave")
    assert (first.turn, first.start) == (0.0, FollowFrom.CONCAVE)
    assert first.bend == pytest.approx(QUARTER)
    assert (second.source, second.target, second.turn, second.start) == (1, 2, 0.0, None)


def test_the_other_way_it_turns_around_first_and_keeps_the_other_hand() -> None:
    (leg,) = plan_legs(ring(SQUARE), 0, "right", 3)
    assert (leg.source, leg.target, leg.side) == (0, 3, "left")
    assert leg.turn == pytest.approx(math.pi)
    assert leg.start is FollowFrom.WALL


def test_at_a_convex_corner_the_wall_begins_a_little_ahead_after_turning_around() -> None:
    graph = ring(SQUARE, convex=0)
    (back,) = plan_legs(graph, 0, "right", 3)
    assert back.start is FollowFrom.GAP
    (onward,) = plan_legs(graph, 0, "right", 1)
    assert onward.start is FollowFrom.CONVEX
    assert onward.bend == pytest.approx(-QUARTER)


def test_who_came_by_the_other_side_goes_on_without_turning() -> None:
    (leg,) = plan_legs(ring(SQUARE), 0, "left", 3)
    assert leg.turn == 0.0
    assert leg.start is FollowFrom.CONCAVE


def test_no_way_is_an_error_and_no_distance_no_legs() -> None:
    graph = ring(SQUARE)
    assert plan_legs(graph, 2, "right", 2) == ()
    for side in ("right", "left"):
        for a, b in [(0, 1), (1, 0), (0, 3), (3, 0)]:
            if graph.graph.has_edge(a, b, side):
                graph.block(a, b, side)
    with pytest.raises(MapError, match="no way from node 0 to node 2"):
        plan_legs(graph, 0, "right", 2)


@given(st.lists(st.floats(0.1, 3.0), min_size=3, max_size=12), st.data())
def test_the_legs_are_a_shortest_way(lengths: list[float], data: st.DataObject) -> None:
    graph = ring(lengths)
    nodes = st.integers(0, len(lengths) - 1)
    start, goal = data.draw(nodes), data.draw(nodes)
    legs = plan_legs(graph, start, data.draw(st.sampled_from(["right", "left"])), goal)
    expected = nx.shortest_path_length(graph.graph, start, goal, weight="distance")
    assert sum(leg.distance for leg in legs) == pytest.approx(expected)
    places = [start, *(leg.target for leg in legs)]
    assert [leg.source for leg in legs] == places[:-1]
    assert places[-1] == goal


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
