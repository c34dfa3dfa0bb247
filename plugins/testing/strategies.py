"""Hypothesis strategies for percepts. Needs the library `hypothesis`, which tolman itself does not."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import strategies as st

from ...world.robot import CONTROL_PERIOD, EPUCK, Percept
from ..trial import FAR, percept


def distances(least: float = 0.0, most: float = 0.1) -> st.SearchStrategy[float]:
    """A distance (m) from the rim in [least, most], or that of a wall that is not there."""
    return st.one_of(st.just(FAR), st.floats(least, most))


def wall_percepts(least: float = 0.0, most: float = 0.1) -> st.SearchStrategy[Percept]:
    """What is sensed between up to four walls, without noise: percepts that a real place can give."""
    gap = distances(least, most)
    return st.builds(percept, front=gap, left=gap, rear=gap, right=gap)


def percepts() -> st.SearchStrategy[Percept]:
    """Any percept that keeps the format: eight infrared values in [0, 4095] that need not fit together."""
    count = len(EPUCK.infrared_angles)
    values = st.tuples(*[st.floats(0.0, 4095.0)] * count)
    return st.builds(lambda infrared: Percept(0, 0.0, infrared, (0.0, 0.0)), values)


def percept_runs(max_size: int = 50) -> st.SearchStrategy[list[Percept]]:
    """Up to `max_size` ticks of any percepts, numbered and timed."""
    return st.lists(percepts(), min_size=1, max_size=max_size).map(_numbered)


def _numbered(run: list[Percept]) -> list[Percept]:
    return [replace(each, tick=tick, time=tick * CONTROL_PERIOD) for tick, each in enumerate(run)]
