"""Made-up results of runs, and what has come of a plan whose runs all ended in such."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from tolman.scripts.experiments.campaign.campaign import Result
from tolman.scripts.experiments.campaign.jobs import SIDES, mapping_job
from tolman.scripts.experiments.campaign.kinds import LOCAL
from tolman.scripts.experiments.campaign.plan import Outcome

WORLD = "env1"


def _mapping(error: float = 0.001, **values: Any) -> Result:
    result = {
        "position_error_m": error,
        "largest_arc_error_m": 0.01,
        "loop_distance_m": 4.6 + error,
        "true_loop_distance_m": 4.6,
        "path_integration_error_m": 0.6,
        "nodes": 10,
        "local_maps": 10,
        "loop_correct": True,
        "reason": "loop closed",
        "finished": True,
        "sim_time_s": 100.0,
        "explored": [[0.001, 0.01]],
        "docked": [[0.001, 0.0]],
        "closing": {"T1": "missed", "T2": "right", "T3": "wrong"},
        "trained": [],
        "estimates": {},
        "collisions": 0,
        "seed": 4000,
    }
    return {**result, **values}


def _trip(**values: Any) -> Result:
    result = {
        "completed": True,
        "end_error_m": 0.001,
        "headings": [0.01],
        "collisions": 0,
        "lost": "",
        "sim_time_s": 50.0,
    }
    return {**result, **values}


def _outcome(kind: str, profile: str, results: list[Result]) -> Outcome:
    jobs = [
        mapping_job(WORLD, SIDES[seed % 2], seed, profile, local_maps=kind == LOCAL)
        for seed in range(len(results))
    ]
    return Outcome({(kind, WORLD, profile): results}, {(kind, WORLD, profile): jobs})


@pytest.fixture(scope="session")
def mapping() -> Callable[..., Result]:
    """`mapping(error, **values)`: a mapping run that got round env1, with a map error in m."""
    return _mapping


@pytest.fixture(scope="session")
def trip() -> Callable[..., Result]:
    """`trip(**values)`: traversals that were completed."""
    return _trip


@pytest.fixture(scope="session")
def outcome() -> Callable[[str, str, list[Result]], Outcome]:
    """`outcome(kind, profile, results)`: of runs in env1, seeds from 0."""
    return _outcome
