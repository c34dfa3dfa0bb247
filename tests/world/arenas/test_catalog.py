from __future__ import annotations

import math

import numpy as np
import pytest
from tolman.world import UnknownWorldError, WorldFileError, built_in_world, built_in_worlds, find_world
from tolman.world.geometry import Plan

from tools.offset_loop import arc_lengths, boundary_loops, offset

WALL_DISTANCE = 0.057
TARGETS = {"env1": (4.61, 10, 10), "env2": (9.09, 22, 24), "env3": (9.87, 26, 28)}
CLOSED = ("env1", "env2", "env3", "env1-mirrored", "room")


@pytest.mark.parametrize("name", sorted(TARGETS))
def test_the_loop_of_the_nodes_has_the_published_length(name: str) -> None:
    length, fewest, most = TARGETS[name]
    (loop,) = boundary_loops(built_in_world(name))
    nodes = offset(loop, WALL_DISTANCE)
    assert sum(arc_lengths(nodes)) == pytest.approx(length, rel=0.01)
    assert fewest <= len(nodes) <= most


@pytest.mark.parametrize("name", CLOSED)
def test_no_arc_is_too_short_to_tell_its_ends_apart(name: str) -> None:
    (loop,) = boundary_loops(built_in_world(name))
    assert min(arc_lengths(offset(loop, WALL_DISTANCE))) >= 0.12


@pytest.mark.parametrize("name", CLOSED)
def test_passages_are_wide_enough_for_two_wall_distances(name: str) -> None:
    """Every free point of a path that keeps 12.4 cm from all walls hangs together: no gap is below 25 cm."""
    plan = Plan(built_in_world(name).shapes)
    (loop,) = boundary_loops(built_in_world(name))
    for x, y in offset(loop, 0.124):
        assert plan.clearance(x, y) >= 0.124 - 1e-9


@pytest.mark.parametrize("name", CLOSED)
def test_starts_follow_a_straight_wall_12_cm_before_a_corner(name: str) -> None:
    spec = built_in_world(name)
    (loop,) = boundary_loops(spec)
    nodes = np.array(offset(loop, WALL_DISTANCE))
    plan = Plan(spec.shapes)
    for side, turn in (("right", -math.pi / 2), ("left", math.pi / 2)):
        pose = spec.start(side)
        assert np.hypot(nodes[:, 0] - pose.x, nodes[:, 1] - pose.y).min() == pytest.approx(0.12, abs=1e-6)
        wall = pose.compose(0.06 * math.cos(turn), 0.06 * math.sin(turn))
        assert plan.contains(wall.x, wall.y), f"no wall on the {side}"
        assert plan.clearance(pose.x, pose.y) == pytest.approx(WALL_DISTANCE)


def test_an_unknown_world_names_the_nearest() -> None:
    with pytest.raises(UnknownWorldError, match="did you mean 'env1'"):
        find_world("enw1")


def test_a_missing_file_is_named() -> None:
    with pytest.raises(WorldFileError, match=r"nowhere\.yaml"):
        find_world("nowhere.yaml")


def test_digests_tell_worlds_apart_but_not_their_names() -> None:
    digests = {built_in_world(name).digest for name in built_in_worlds()}
    assert len(digests) == len(built_in_worlds())
