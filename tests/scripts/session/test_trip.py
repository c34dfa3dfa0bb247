"""Trips over a saved map, in the kinematic twin."""

from __future__ import annotations

from pathlib import Path

import pytest
from tolman.maps.errors import UnknownNodeError
from tolman.scripts.session.requests import GoRequest, MapRequest, Progress, SessionError
from tolman.scripts.session.simulation import go_to, map_world
from tolman.scripts.session.trip import GoReport

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


@pytest.fixture(scope="module", params=["right", "left"])
def env1(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """env1 mapped with the wall on this side."""
    path = tmp_path_factory.mktemp("trips") / f"{request.param}.tolman"
    map_world(
        MapRequest(
            world="env1", output=path, side=request.param, global_only=True, engine="kinematic", seed=2
        )
    )
    return path


def go(path: Path, to: int | str, **fields: object) -> GoReport:
    return go_to(GoRequest(map=path, to=to, engine="kinematic", **fields))  # type: ignore[arg-type]


@pytest.mark.parametrize(("origin", "to"), [(0, 1), (0, 9), (2, 7), (7, 2), (8, 3)])
def test_it_arrives_from_either_direction_at_any_kind_of_corner(env1: Path, origin: int, to: int) -> None:
    report = go(env1, to, origin=origin, seed=7)
    assert (report.reached, report.lost) == (True, False)
    assert report.path[0] == origin
    assert report.path[-1] == to
    assert report.position_error_m is not None
    assert report.position_error_m < 0.01
    assert report.heading_error_deg is not None
    assert report.heading_error_deg < 6.0
    assert report.collisions == 0


def test_the_shorter_way_round_is_taken(env1: Path) -> None:
    assert go(env1, 9, origin=0).path == (0, 9)
    report = go(env1, 3, origin=1)
    assert report.path == (1, 2, 3)
    assert [leg["to"] for leg in report.legs] == [2, 3]
    assert report.distance_m == pytest.approx(sum(leg["distance_m"] for leg in report.legs))


def test_without_a_start_it_begins_where_the_robot_was_when_the_map_was_saved(env1: Path) -> None:
    report = go(env1, 6)
    assert report.reached
    assert report.path[0] == 2
    assert report.position_error_m is not None
    assert report.position_error_m < 0.01


def test_nodes_go_by_name_too(env1: Path) -> None:
    assert go(env1, "n1", origin="n0").path == (0, 1)


def test_to_stay_where_it_is_takes_no_way(env1: Path) -> None:
    report = go(env1, 4, origin=4)
    assert report.reached
    assert report.legs == ()
    assert report.distance_m == 0.0


def test_progress_is_told(env1: Path) -> None:
    told: list[Progress] = []
    go_to(GoRequest(map=env1, to=1, origin=0, engine="kinematic"), told.append)
    assert told
    assert all("node 1" in each.message for each in told)


def test_what_is_not_in_the_map_is_refused(env1: Path) -> None:
    with pytest.raises(UnknownNodeError, match="no node 'kitchen' in this map"):
        go(env1, "kitchen")
    with pytest.raises(UnknownNodeError):
        go(env1, 3, origin=77)


def test_another_world_is_refused(env1: Path) -> None:
    with pytest.raises(SessionError, match="a map of env1, not of room"):
        go(env1, 1, world="room")


def test_a_map_whose_robot_never_stood_at_a_node_needs_a_start(tmp_path: Path) -> None:
    path = tmp_path / "empty.tolman"
    map_world(
        MapRequest(world="env1", output=path, global_only=True, engine="kinematic", max_nodes=1, max_time=0.5)
    )
    with pytest.raises((SessionError, UnknownNodeError)):
        go(path, 0)
