"""Navigation as published: straight-line distances, sides, turning around, correction by the best unit."""

import math
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent
from tolman.agent.navigation.published import ThesisNavigationConfig, ThesisNavigator
from tolman.behaviors.local_go_to import LocalGoTo
from tolman.behaviors.look_around import LookAroundBehavior
from tolman.behaviors.reactive_wall_following import ReactiveWallFollowing
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta
from tolman.world import open_world
from tolman.world.robot import Pose, wrap_angle

START = Pose(0.60, 0.057, 0.0)
"""Beside env1's lower wall, pointing along it: the wall is on the right."""


def trip(distance: float, config: ThesisNavigationConfig) -> tuple[ThesisNavigator, Any]:
    world = open_world("env1", seed=1, noise="none", engine="kinematic", start=START)
    hybrid = HybridMap(MapMeta(side="right"))
    for _ in range(2):
        hybrid.add_node()
    hybrid.add_arc(0, 1, "right", distance)
    agent = Agent(world.robots[0], [ReactiveWallFollowing(), LookAroundBehavior(), LocalGoTo()])
    return ThesisNavigator(agent, hybrid, 0, None, config), world


def run(navigator: ThesisNavigator, world: Any, seconds: float = 120.0) -> None:
    for _ in range(round(seconds / 0.032)):
        if navigator.done:
            return
        navigator.agent.tick()
        world.step()


def test_an_arc_ends_at_its_straight_line_distance() -> None:
    navigator, world = trip(0.2, ThesisNavigationConfig(correct=False))
    navigator.go(1)
    run(navigator, world)
    assert navigator.reached
    assert (navigator.node, navigator.path) == (1, [0, 1])
    assert world.true_pose().distance_to(START) == pytest.approx(0.2, abs=0.005)


def test_for_the_other_side_it_turns_around_first() -> None:
    navigator, world = trip(0.2, ThesisNavigationConfig(correct=False))
    navigator.go(1)
    run(navigator, world)
    navigator.drive(navigator.map.path(1, 0), face=False)
    run(navigator, world)
    assert navigator.reached
    assert world.true_pose().distance_to(START) < 0.02
    assert abs(wrap_angle(world.true_pose().heading - math.pi)) < 0.3


def test_a_distance_that_is_never_reached_is_given_up() -> None:
    navigator, world = trip(3.0, ThesisNavigationConfig(correct=False, longest=0.5, spare=0.0))
    navigator.go(1)
    run(navigator, world)
    assert navigator.done
    assert not navigator.reached
    assert "3.00 m away from node 0" in navigator.reason


def test_where_the_way_to_the_middle_is_barred_it_faces_the_entry_heading_all_the_same() -> None:
    navigator, world = trip(0.1, ThesisNavigationConfig(correct=True))
    # The map says that it stands to the left of the node: the wall on its right is in the way.
    places = np.array([[0.0, 0.06], [0.0, 0.06]])
    navigator.map.graph.nodes[1]["local_map"] = LocalMap.build(places, places, np.zeros((2, 4, 16, 16)))
    navigator.go(1)
    run(navigator, world)
    assert navigator.reached
    assert world.true_pose().y > 0.04
    assert abs(wrap_angle(world.true_pose().heading)) < 0.1


def test_the_place_of_the_best_unit_is_taken_for_its_own_and_it_drives_to_the_middle() -> None:
    navigator, world = trip(0.1, ThesisNavigationConfig(correct=True))
    # Whatever it sees, the map says that it is 2 cm short of the node.
    places = np.array([[-0.02, 0.0], [-0.02, 0.0]])
    navigator.map.graph.nodes[1]["local_map"] = LocalMap.build(places, places, np.zeros((2, 4, 16, 16)))
    navigator.go(1)
    run(navigator, world)
    assert navigator.reached
    assert navigator.corrections[0].place == pytest.approx((-0.02, 0.0))
    assert world.true_pose().x == pytest.approx(START.x + 0.12, abs=0.005)


def test_no_way_is_said_so() -> None:
    navigator, _ = trip(0.2, ThesisNavigationConfig())
    navigator.map.add_node()
    navigator.go(2)
    assert navigator.done
    assert "no way" in navigator.reason
