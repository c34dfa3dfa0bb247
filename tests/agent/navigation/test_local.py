from __future__ import annotations

import math
from enum import Enum
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent
from tolman.agent.behavior import Behavior, Context, Proposal
from tolman.agent.estimation.local_filter import LocalPose
from tolman.agent.events import BehaviorFinished
from tolman.agent.goals import DrivePath, PlacesDriven
from tolman.agent.navigation.local import LocalNavigator, is_square
from tolman.maps.errors import MapError
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta
from tolman.plugins.testing import ScriptedRobot
from tolman.world.robot import Percept, Pose

QUARTER = 0.5 * math.pi


class Idle(Enum):
    IDLE = "idle"


class LocalPuppet(Behavior):
    """Proposes nothing; keeps the goals it was given."""

    name = "local-go-to"
    Goal = DrivePath
    States, initial = Idle, Idle.IDLE
    goals: list[Any]

    def on_start(self, context: Context) -> None:
        self.goals = [*getattr(self, "goals", []), self.goal]

    def idle(self, percept: Percept, context: Context) -> Proposal | None:
        return None


def finish(agent: Agent, behavior: str, succeeded: bool, result: Any, reason: str = "") -> None:
    agent.bus.publish(
        BehaviorFinished(time=1.0, behavior=behavior, succeeded=succeeded, reason=reason, result=result)
    )
    agent.tick()
    agent.tick()


def local(corner: str = "concave", turn: float = QUARTER) -> tuple[LocalNavigator, LocalPuppet, Agent]:
    places = np.random.default_rng(0).uniform(-0.12, 0.12, (400, 2))
    graph = HybridMap(MapMeta(side="right"))
    graph.add_node(corner=corner, turn=turn, local_map=LocalMap.build(places))
    puppet = LocalPuppet()
    agent = Agent(ScriptedRobot(), [puppet])
    return LocalNavigator(agent, graph, 0), puppet, agent


def farthest(trip: LocalNavigator) -> int:
    return trip.local_map.nearest_unit(0.12, 0.12)


def test_a_node_without_a_local_map_cannot_be_navigated_in() -> None:
    graph = HybridMap()
    graph.add_node()
    with pytest.raises(MapError, match="node 0 has no local map"):
        LocalNavigator(Agent(ScriptedRobot(), [LocalPuppet()]), graph, 0)


def test_in_a_local_map_it_drives_from_unit_to_unit() -> None:
    trip, puppet, agent = local()
    goal = farthest(trip)
    trip.go(goal)
    through = puppet.goals[-1]
    assert isinstance(through, DrivePath)
    assert through.belief is not None
    assert through.places[-1] == pytest.approx(trip.local_map.position(goal))
    end = Pose(*through.places[-1], 0.7)
    finish(agent, "local-go-to", True, PlacesDriven(len(through.places), end))
    assert (trip.done, trip.reached, trip.unit, trip.pose) == (True, True, goal, end)


def test_the_way_home_ends_at_the_node_facing_the_entry_heading() -> None:
    trip, puppet, agent = local()
    trip.go(farthest(trip))
    finish(agent, "local-go-to", True, PlacesDriven(len(puppet.goals[-1].places), Pose(0.1, 0.1, 1.0)))
    trip.home()
    through = puppet.goals[-1]
    assert through.places[-1] == (0.0, 0.0)
    assert through.heading == 0.0


def test_who_cannot_even_reach_the_unit_it_begins_at_gives_up() -> None:
    trip, _, agent = local()
    trip.go(farthest(trip))
    finish(agent, "local-go-to", False, PlacesDriven(0, Pose()), "blocked")
    assert (trip.done, trip.reached, trip.reason) == (True, False, "blocked")
    assert not trip.local_map.blocked


def test_an_obstacle_is_remembered_and_another_way_tried_until_there_is_none() -> None:
    trip, _, agent = local()
    trip.go(farthest(trip))
    tries = 0
    while not trip.done and tries < 100:
        tries += 1
        finish(agent, "local-go-to", False, PlacesDriven(1, trip.pose), "blocked")
    assert trip.done
    assert not trip.reached
    assert tries > 1
    assert len(trip.local_map.blocked) == tries
    assert all(trip.local_map.nearest_unit() in edge for edge in trip.local_map.blocked)


def arrive(agent: Agent, puppet: LocalPuppet, pose: LocalPose) -> None:
    """The behavior has driven all it was asked to, and holds this pose now."""
    places = puppet.goals[-1].places
    pose.x, pose.y = places[-1]
    finish(agent, "local-go-to", True, PlacesDriven(len(places), pose.pose, pose.belief()))


def known(goal: DrivePath) -> LocalPose:
    assert goal.belief is not None
    return LocalPose.of(goal.belief)


def test_it_knows_the_walls_of_a_square_corner_beforehand() -> None:
    trip, puppet, _ = local()
    trip.go(farthest(trip))
    normals = [mark.normal for mark in known(puppet.goals[-1]).landmarks]
    assert normals == pytest.approx([-QUARTER, 0.0])


def test_a_doubtful_pose_is_mended_where_walls_are_seen_before_it_goes_on() -> None:
    trip, puppet, agent = local()
    trip.go(farthest(trip))
    lost = known(puppet.goals[-1])
    for _ in range(90):
        lost.move(0.0, 1.0)
    assert lost.doubtful
    arrive(agent, puppet, lost)
    goal = trip.local_map.nearest_unit(-0.12, 0.12)
    trip.go(goal)
    assert puppet.goals[-1].fix
    assert math.dist(puppet.goals[-1].places[-1], (0.0, 0.0)) < 0.01
    arrive(agent, puppet, LocalPose())
    assert not puppet.goals[-1].fix
    assert puppet.goals[-1].places[-1] == pytest.approx(trip.local_map.position(goal))


def test_home_at_a_convex_corner_it_goes_by_where_both_walls_are_seen() -> None:
    trip, puppet, agent = local("convex", -QUARTER)
    trip.home()
    ends = []
    while not trip.done:
        ends.append((puppet.goals[-1].places[-1], puppet.goals[-1].fix))
        arrive(agent, puppet, known(puppet.goals[-1]))
    assert [fix for _, fix in ends] == [True, True, False]
    assert [end for end, _ in ends] == [
        pytest.approx((0.0, -0.087)),
        pytest.approx((-0.087, 0.0)),
        (0.0, 0.0),
    ]


def test_a_vantage_point_that_cannot_be_reached_is_left_out() -> None:
    trip, puppet, agent = local("convex", -QUARTER)
    trip.home()
    through = puppet.goals[-1]
    finish(
        agent, "local-go-to", False, PlacesDriven(len(through.places) - 1, Pose(), through.belief), "blocked"
    )
    assert not trip.done
    assert puppet.goals[-1].places[-1] == pytest.approx((-0.087, 0.0))


def test_without_landmarks_it_drives_by_path_integration_alone() -> None:
    places = np.random.default_rng(0).uniform(-0.12, 0.12, (400, 2))
    graph = HybridMap()
    graph.add_node(local_map=LocalMap.build(places))
    puppet = LocalPuppet()
    trip = LocalNavigator(Agent(ScriptedRobot(), [puppet]), graph, 0, landmarks=False)
    trip.home()
    assert isinstance(puppet.goals[-1], DrivePath)


def test_a_room_is_square_where_all_turns_are_quarters_but_for_measuring() -> None:
    square, slanted = HybridMap(), HybridMap()
    for turn in (1.55, 1.60, -1.57, 1.56):
        square.add_node(corner="concave", turn=turn)
    for turn in (1.55, 1.05, 0.8):
        slanted.add_node(corner="concave", turn=turn)
    assert is_square(square)
    assert not is_square(slanted)
    assert not is_square(HybridMap())
