"""Online training against MiniSom, step for step, on the cases of the notes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tolman.maps.som.schedules import OnlineConfig
from tolman.maps.som.som import SOM

minisom = pytest.importorskip("minisom")

IRIS = Path(__file__).parent / "data" / "iris.csv"


def iris() -> NDArray[np.float64]:
    data = np.loadtxt(IRIS, delimiter=",")
    return np.asarray((data - data.mean(axis=0)) / data.std(axis=0))


def to_ours(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """MiniSom's (x, y, dims) in our unit order; mirrored when its odd rows are not the ones to the right."""
    rows = weights.transpose(1, 0, 2)
    if rows.shape[0] % 2 == 0:
        rows = rows[::-1]
    return rows.reshape(-1, weights.shape[2]).copy()


def trained_pair(
    x: int, y: int, sigma: float, data: NDArray[np.float64], steps: int, topology: Any, function: Any
) -> tuple[Any, SOM]:
    oracle = minisom.MiniSom(
        x,
        y,
        data.shape[1],
        sigma=sigma,
        learning_rate=0.5,
        topology=topology,
        neighborhood_function=function,
        random_seed=1,
        activation_distance="euclidean",
    )
    ours = SOM(y, x, topology, to_ours(oracle.get_weights()))
    oracle.train(data, steps)
    config = OnlineConfig(
        steps=steps,
        max_steps=steps,
        rate=0.5,
        decay="inverse",
        neighborhood=function,
        radius=sigma,
        order="sequence",
        stop_delta=0.0,
    )
    return oracle, ours.partial_fit(data, config)


@pytest.mark.parametrize(
    ("x", "y", "sigma", "quantization", "topographic"),
    [(5, 5, 2.0, 0.48837, 0.04667), (7, 4, 2.0, 0.46288, 0.07333), (9, 6, 3.0, 0.44258, 0.02000)],
)
def test_hexagonal_gaussian_training_equals_minisoms(
    x: int, y: int, sigma: float, quantization: float, topographic: float
) -> None:
    data = iris()
    oracle, ours = trained_pair(x, y, sigma, data, 2000, "hexagonal", "gaussian")
    assert np.abs(ours.weights - to_ours(oracle.get_weights())).max() < 1e-12
    assert ours.quantization_error(data) == pytest.approx(oracle.quantization_error(data), abs=1e-12)
    assert ours.topographic_error(data) == pytest.approx(oracle.topographic_error(data), abs=1e-12)
    assert ours.quantization_error(data) == pytest.approx(quantization, abs=5e-6)
    assert ours.topographic_error(data) == pytest.approx(topographic, abs=5e-6)


def test_rectangular_gaussian_training_equals_minisoms() -> None:
    data = iris()
    oracle, ours = trained_pair(6, 5, 1.5, data, 1000, "rectangular", "gaussian")
    assert np.abs(ours.weights - to_ours(oracle.get_weights())[:30]).max() < 1e-12
    assert ours.topographic_error(data) == pytest.approx(oracle.topographic_error(data), abs=1e-12)


def test_gram_form_equals_minisoms_on_long_samples() -> None:
    data = np.random.default_rng(4).uniform(0.0, 1.0, (20, 300))
    oracle, ours = trained_pair(5, 5, 2.0, data, 400, "hexagonal", "gaussian")
    assert np.abs(ours.weights - to_ours(oracle.get_weights())).max() < 1e-12


def test_winners_equal_minisoms() -> None:
    data = iris()
    oracle, ours = trained_pair(5, 5, 2.0, data, 500, "hexagonal", "gaussian")
    expected = [j * 5 + i for i, j in (oracle.winner(row) for row in data)]
    assert ours.winners(data).tolist() == expected
