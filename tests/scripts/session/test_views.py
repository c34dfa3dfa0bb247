"""Starts that are not told in rooms whose walls all look the same to the infrared, in the kinematic twin."""

from __future__ import annotations

from pathlib import Path

import pytest
from tolman.scripts.session.requests import GoRequest, MapRequest
from tolman.scripts.session.simulation import go_to, map_world
from tolman.scripts.session.trip import GoReport

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


def mapped(world: str, side: str, path: Path) -> Path:
    map_world(MapRequest(world=world, output=path, side=side, engine="kinematic", seed=5))
    return path


@pytest.fixture(scope="module", params=["right", "left"])
def patterned(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("views")
    return mapped("symmetric-textured", request.param, folder / f"{request.param}.tolman")


def lost(path: Path, seed: int, **fields: object) -> GoReport:
    request = GoRequest(map=path, to=1, lost=True, seed=seed, engine="kinematic", **fields)  # type: ignore[arg-type]
    return go_to(request)


@pytest.mark.parametrize("seed", range(4))
def test_where_only_the_walls_patterns_differ_views_tell_the_place(patterned: Path, seed: int) -> None:
    report = lost(patterned, seed)
    assert report.reached, report.reason
    assert report.position_error_m is not None
    assert report.position_error_m < 0.02
    assert report.localized_after_m is not None
    assert report.localized_after_m < 2.7


@pytest.mark.parametrize("side", ["right", "left"])
def test_where_views_are_alike_too_it_is_ambiguous(tmp_path: Path, side: str) -> None:
    path = mapped("symmetric", side, tmp_path / "same.tolman")
    for seed in range(3):
        report = lost(path, seed)
        assert not report.reached
        assert report.reason.startswith("ambiguous")
