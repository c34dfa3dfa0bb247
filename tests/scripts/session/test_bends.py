"""Mapping and driving where walls bend: blunt corners, round pillars, rooms without a corner; no DART."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from tolman.scripts.session.mapping import MapReport
from tolman.scripts.session.requests import GoRequest, MapRequest
from tolman.scripts.session.simulation import go_to, map_world

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

ROUND_POINTS = [(0.5 * math.cos(math.tau * i / 72), 0.5 * math.sin(math.tau * i / 72)) for i in range(72)]


def walls(points: list[tuple[float, float]], start: tuple[float, float, float]) -> str:
    """A world of walls from point to point, with both starts at one pose (m, m, degrees)."""
    lines = [
        f"  - {{from: [{x0:.4f}, {y0:.4f}], to: [{x1:.4f}, {y1:.4f}]}}"
        for (x0, y0), (x1, y1) in zip(points, [*points[1:], points[0]], strict=True)
    ]
    x, y, heading = start
    starts = f"  right: [{x}, {y}, {heading}]\n  left: [{x}, {y}, {heading + 180}]"
    return "tolman-world: 1\nwalls:\n" + "\n".join(lines) + f"\nstarts:\n{starts}\n"


FULL_SWEEP = walls(ROUND_POINTS, (0.0, -0.433, 0))
BLUNT = walls(
    [(-0.7, -0.3), (0.0, -0.45), (0.7, -0.3), (0.6, 0.4), (0.1, 0.5), (-0.6, 0.35)], (0.3, -0.317, 12)
)
PILLAR = """\
tolman-world: 1
room: {size: [1.2, 1.0]}
cylinders:
  - {at: [1.1, 0.1], radius: 0.3}
  - {at: [0.3, 1.0], radius: 0.06}
"""


def mapped(folder: Path, text: str, **fields: object) -> MapReport:
    (folder / "world.yaml").write_text(text)
    values = {"world": str(folder / "world.yaml"), "output": folder / "map.tolman", **fields}
    return map_world(MapRequest(global_only=True, engine="kinematic", **values))  # type: ignore[arg-type]


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize(("text", "nodes"), [(BLUNT, 6), (PILLAR, 10)])
def test_a_boundary_that_bends_closes_at_the_right_place_in_the_first_round(
    tmp_path: Path, text: str, nodes: int, side: str
) -> None:
    report = mapped(tmp_path, text, side=side, seed=5)
    assert (report.loop_correct, report.collisions, report.reason) == (True, 0, "loop closed")
    assert abs(report.nodes - nodes) <= 1


def test_a_round_room_closes_and_its_bends_are_driven_to_both_ways(tmp_path: Path) -> None:
    report = mapped(tmp_path, FULL_SWEEP, seed=2)
    assert (report.loop_correct, report.nodes, report.collisions) == (True, 6, 0)
    assert report.loop_distance_m == pytest.approx(math.tau * (0.49 - 0.057), abs=0.2)
    for target, error in ((2, 0.03), (5, 0.20)):
        trip = go_to(
            GoRequest(
                map=tmp_path / "map.tolman",
                to=target,
                origin=0,
                engine="kinematic",
                seed=7,
                world=str(tmp_path / "world.yaml"),
            )
        )
        assert trip.reached, trip.reason
        assert trip.position_error_m is not None
        assert trip.position_error_m < error


def test_without_a_corner_in_a_room_too_large_for_odometry_it_says_that_bends_are_ambiguous(
    tmp_path: Path,
) -> None:
    large = walls([(2.6 * x, 2.6 * y) for x, y in ROUND_POINTS], (0.0, -1.23, 0))
    report = mapped(tmp_path, large, seed=1)
    assert not report.loop_closed
    assert report.reason.startswith("ambiguous: no corner")
