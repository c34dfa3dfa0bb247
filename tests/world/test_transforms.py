"""Worlds made from worlds: what a turn, a mirror and a scale change, and what they leave."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.world import Pose, WorldSpec, built_in_world, open_world
from tolman.world.geometry import Plan
from tolman.world.spec import Box, Cylinder, MovableBox, Polygon, Start, Wall
from tolman.world.transforms import mirrored, rotated, scaled

ODD = math.radians(17.0)
ALL_KINDS = WorldSpec(
    "kinds",
    (
        Box(0.5, 0.1, 0.3, 0.05, 0.2),
        Cylinder(0.2, 0.7, 0.06),
        Polygon(((0.6, 0.6), (0.8, 0.6), (0.7, 0.9))),
        Wall((0.0, 0.0), (0.0, 1.0)),
    ),
    (Start("right", Pose(0.4, 0.4, 0.3)),),
    (MovableBox(Box(0.3, 0.3, 0.05, 0.05)),),
    (Pose(0.5, 0.5, 1.0),),
)


def clearances(spec: WorldSpec) -> list[float]:
    plan = Plan((*spec.shapes, *(movable.box for movable in spec.movable)))
    places = [*(start.pose for start in spec.starts), *spec.robots]
    return [plan.clearance(pose.x, pose.y) for pose in places]


@given(angle=st.floats(-10.0, 10.0))
def test_a_turned_world_is_as_far_from_its_robots_as_before(angle: float) -> None:
    assert clearances(rotated(ALL_KINDS, angle)) == pytest.approx(clearances(ALL_KINDS), abs=1e-9)


def test_a_turn_and_the_turn_back_give_the_same_room() -> None:
    spec = built_in_world("env2")
    there = rotated(spec, 0.5 * math.pi)  # a quarter keeps the middle of the bounds where it is
    back = rotated(there, -0.5 * math.pi)
    for one, other in zip(Plan(spec.shapes).outlines, Plan(back.shapes).outlines, strict=True):
        assert np.allclose(one, other)
    assert rotated(spec, 0.0) is spec


@pytest.mark.parametrize("change", [lambda spec: rotated(spec, ODD), mirrored])
def test_an_infrared_sensor_reads_the_same_in_a_turned_or_mirrored_room(change: object) -> None:
    spec = built_in_world("env1")
    changed = change(spec)  # type: ignore[operator]
    side = {"right": "left", "left": "right"} if change is mirrored else {"right": "right"}
    worlds = [open_world(spec, engine="kinematic", noise="none", start="right")]
    worlds.append(open_world(changed, engine="kinematic", noise="none", start=side["right"]))
    one, other = (world.robots[0].sense().infrared for world in worlds)
    other = other[::-1] if change is mirrored else other
    assert one == pytest.approx(other, abs=0.5)


def test_a_scaled_room_keeps_its_heights() -> None:
    spec = scaled(ALL_KINDS, 0.8)
    assert clearances(spec) == pytest.approx([0.8 * value for value in clearances(ALL_KINDS)])
    assert [shape.height for shape in spec.shapes] == [shape.height for shape in ALL_KINDS.shapes]


def test_a_turned_world_is_another_world() -> None:
    assert rotated(ALL_KINDS, ODD).digest != ALL_KINDS.digest
    assert rotated(replace(ALL_KINDS, name="x"), ODD).digest == rotated(ALL_KINDS, ODD).digest
