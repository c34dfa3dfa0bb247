"""What the benchmarks of maps measure: that their places are what they say, and how figures are told."""

import numpy as np
import pytest
from tolman.maps.local.local_map import LocalMap
from tolman.world.geometry import Plan
from tolman.world.spec import Wall

from benchmarks.figures import Figure, report
from benchmarks.places import KINDS, crosses, sample_place


@pytest.mark.parametrize("seed", range(len(KINDS)))
def test_places_are_sampled_where_the_body_fits_and_repeat(seed: int) -> None:
    place = sample_place(seed)
    assert np.array_equal(place.positions, sample_place(seed).positions)
    assert np.abs(place.local(place.positions)).max() < 0.12
    assert place.views.shape == (len(place.view_positions), 4, 16, 16)
    assert not any(place.plan.contains(*spot) for spot in place.positions.tolist())
    steps = np.linalg.norm(np.diff(place.positions, axis=0), axis=1)
    assert np.median(steps) < 0.025


def test_free_space_beside_a_thin_wall_keeps_to_either_side_of_it() -> None:
    place = sample_place(KINDS.index("two thin walls"))
    local = LocalMap.build(place.local(place.positions))
    units = local.metric.weights + np.array(place.center)
    assert not any(crosses(place.plan, units[i], units[j]) for i, j in local.edges.tolist())


def test_a_segment_crosses_a_wall_or_passes_its_end() -> None:
    wall = Plan([Wall((0.0, 0.0), (1.0, 0.0), 0.01)])
    assert crosses(wall, np.array([0.5, -0.1]), np.array([0.5, 0.1]))
    assert not crosses(wall, np.array([1.5, -0.1]), np.array([1.5, 0.1]))


def test_figures_say_whether_they_reach_their_target(capsys: pytest.CaptureFixture[str]) -> None:
    figures = [Figure("a", 1.0, "ms", 2.0), Figure("b", 3.0, "x", 4.0, True), Figure("c", 5.0, "MB")]
    assert [figure.reached for figure in figures] == [True, False, True]
    assert report(figures) == 1
    told = capsys.readouterr().out.splitlines()
    assert "<= 2" in told[0]
    assert told[1].endswith(">= 4   MISSED")
