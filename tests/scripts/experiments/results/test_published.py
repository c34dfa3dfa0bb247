"""The published figures agree with themselves, but for the slips that are noted."""

import pytest
from tolman.scripts.experiments.results.published import PUBLISHED, Table


@pytest.mark.parametrize("table", PUBLISHED.values(), ids=PUBLISHED)
def test_means_lie_between_least_and_greatest(table: Table) -> None:
    for figure in table.figures.values():
        for low, mean, high in zip(figure.least, figure.mean, figure.greatest, strict=True):
            assert low is None or mean is None or high is None or low <= mean <= high


def test_the_runs_of_loop_closing_add_up_to_six() -> None:
    figures = PUBLISHED["4.18"].figures
    for threshold in ("T1", "T2", "T3"):
        counts = [figures[f"{threshold}, {kind}"].mean for kind in ("wrong", "right", "missed")]
        assert [sum(filter(None, column)) for column in zip(*counts, strict=True)] == [6, 6, 6]


def test_the_mean_over_the_environments_is_what_the_noise_preset_is_calibrated_to() -> None:
    values = PUBLISHED["4.3"].figures["position error"].mean
    assert sum(filter(None, values)) / 3 == pytest.approx(79, abs=0.5)
