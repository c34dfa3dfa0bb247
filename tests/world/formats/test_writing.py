"""A world that was written reads as what it was."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.world import WorldError, WorldSpec
from tolman.world.formats.worldfile import parse_world
from tolman.world.formats.writing import world_text
from tolman.world.robot import Pose
from tolman.world.spec import Box, Cylinder, MovableBox, Polygon, Shape, Start, Surface, Wall

LENGTH = st.integers(1, 5_000_000).map(lambda micrometers: micrometers / 1e6 + 0.002)
PLACE = st.tuples(*[st.integers(-5_000_000, 5_000_000).map(lambda n: n / 1e6)] * 2)
LOOK = st.sampled_from([Surface(), Surface((0.2, 0.4, 0.6))])
HEIGHT = st.sampled_from([0.1, 0.05])


def shapes() -> st.SearchStrategy[Shape]:
    boxes = st.builds(
        lambda at, w, d, deg, h, look: Box(at[0], at[1], w, d, math.radians(deg), h, look),
        PLACE, LENGTH, LENGTH, st.integers(-170, 170), HEIGHT, LOOK,
    )  # fmt: skip
    cylinders = st.builds(
        lambda at, r, h, look: Cylinder(at[0], at[1], r, h, look), PLACE, LENGTH, HEIGHT, LOOK
    )
    walls = st.builds(
        lambda at, dx, t, h, look: Wall(at, (at[0] + dx, at[1]), t, h, look),
        PLACE,
        LENGTH,
        LENGTH,
        HEIGHT,
        LOOK,
    )
    polygons = st.builds(
        lambda at, a, b, h, look: Polygon((at, (at[0] + a, at[1]), (at[0], at[1] + b)), h, look),
        PLACE, LENGTH, LENGTH, HEIGHT, LOOK,
    )  # fmt: skip
    return st.one_of(boxes, cylinders, walls, polygons)


@given(st.lists(shapes(), min_size=1, max_size=6))
def test_shapes_come_back_as_they_were_to_a_micrometer(drawn: list[Shape]) -> None:
    start = Start("right", Pose(0.25, -0.5, math.radians(30.0)))
    spec = WorldSpec("w", tuple(drawn), (start,), robots=(Pose(0.1, 0.2, 0.0),), description="a test")
    read = parse_world(world_text(spec), "w.yaml", "w")
    assert (read.description, len(read.shapes)) == ("a test", len(drawn))
    key = lambda shape: (type(shape).__name__, shape.outline())  # noqa: E731
    for one, other in zip(sorted(read.shapes, key=key), sorted(drawn, key=key), strict=True):
        assert type(one) is type(other)
        for here, there in zip(one.outline(), other.outline(), strict=True):
            assert here == pytest.approx(there, abs=3e-6)
        assert (one.height, one.surface) == (other.height, other.surface)
    assert read.starts[0].pose.heading == pytest.approx(math.radians(30.0), abs=1e-7)
    assert read.robots == (Pose(0.1, 0.2, 0.0),)


def test_what_a_file_cannot_say_is_refused_and_not_dropped() -> None:
    movable = WorldSpec("w", (Box(0, 0, 1, 1),), movable=(MovableBox(Box(0, 0, 0.1, 0.1)),))
    with pytest.raises(WorldError, match="cannot be written"):
        world_text(movable)
