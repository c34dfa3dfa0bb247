from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.estimation.local_filter import LocalPose
from tolman.agent.exploration.panoramas import QUARTER, Panorama, PanoramaSamples, view_order
from tolman.world.robot import EPUCK, wrap_angle

headings = st.floats(-math.pi, math.pi)


def turned(order: list[int], heading: float, after: float | None) -> float:
    stops = [QUARTER * direction for direction in order]
    ways = [heading, *stops] + ([] if after is None else [after])
    return sum(abs(wrap_angle(b - a)) for a, b in pairwise(ways))


@given(headings, st.none() | headings)
def test_all_four_directions_are_met_turning_as_little_as_can_be(heading: float, after: float | None) -> None:
    order = view_order(heading, after)
    assert sorted(order) == [0, 1, 2, 3]
    ways = [[(first + sense * k) % 4 for k in range(4)] for first in range(4) for sense in (1, -1)]
    least = min(turned(way, heading, after) for way in ways)
    assert turned(order, heading, after) == pytest.approx(least)


def test_facing_ahead_and_bound_for_the_right_it_turns_left_around() -> None:
    assert view_order(0.0, -QUARTER) == [0, 1, 2, 3]


def look_around(heading: float) -> Panorama:
    """What the four views see of a scene that changes with the bearing, all turned by `heading` (rad)."""
    focal = 8.0 / math.tan(0.5 * EPUCK.camera_field_of_view)
    columns = np.arctan((7.5 - np.arange(16)) / focal)
    bearing = heading + QUARTER * np.arange(4)[:, None] + columns
    light = 0.5 + 0.2 * np.sin(3.0 * bearing) + 0.2 * np.sin(11.0 * bearing + 1.0)
    return np.repeat(light[:, None, :], 16, axis=1).astype(np.float32)


def wandered(way: float) -> LocalPose:
    pose = LocalPose()
    for _ in range(60):
        pose.move(0.0, 0.05)
        pose.move(0.0, -0.05)
    pose.move(way, 0.0)
    return pose


@given(st.floats(-0.1, 0.1))
def test_a_panorama_taken_at_the_same_place_corrects_the_heading(error: float) -> None:
    """It holds its heading to be 0 and looks along the axes, but stands turned by `error`."""
    samples, pose = PanoramaSamples(), wandered(0.0)
    samples.add(look_around(0.0), LocalPose())
    samples.compare(look_around(error), pose, EPUCK.camera_field_of_view, 3, 0.015)
    assert abs(pose.heading - error) <= 0.5 * abs(error) + 0.003


def test_panoramas_from_farther_off_do_not_count() -> None:
    samples, pose = PanoramaSamples(), wandered(0.02)
    samples.add(look_around(0.0), LocalPose())
    samples.compare(look_around(0.05), pose, EPUCK.camera_field_of_view, 3, 0.015)
    assert pose.heading == pytest.approx(0.0, abs=1e-9)
