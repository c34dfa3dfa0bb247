from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tolman.maps.errors import MapError, NotTrainedError
from tolman.maps.som.lattice import Lattice
from tolman.maps.som.schedules import (
    BATCH,
    METRIC_1,
    METRIC_2,
    PERCEPTUAL_1,
    PERCEPTUAL_2,
    BatchConfig,
    OnlineConfig,
)
from tolman.maps.som.som import SOM


def places(count: int = 90, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(0.0, 1.0, (count, 2))


def views(count: int = 24, seed: int = 0, dims: int = 400) -> NDArray[np.float64]:
    """Smooth 'images': few underlying causes, many pixels."""
    rng = np.random.default_rng(seed)
    cause, pixel = rng.uniform(-1.0, 1.0, (count, 2)), rng.normal(0.0, 0.1, (2, dims))
    return np.asarray(np.clip(0.5 + cause @ pixel + rng.normal(0.0, 0.01, (count, dims)), 0.0, 1.0))


# -- the lattice


@given(rows=st.integers(1, 7), cols=st.integers(1, 7), topology=st.sampled_from(["hexagonal", "rectangular"]))
def test_lattice_steps_are_shortest_paths_over_direct_neighbors(rows: int, cols: int, topology: str) -> None:
    lattice = Lattice(rows, cols, topology)  # type: ignore[arg-type]
    reach = 1.01 if topology == "hexagonal" else math.sqrt(2.0) + 0.01
    near = (lattice.squared_distances < reach**2) & ~np.eye(lattice.units, dtype=bool)
    assert np.array_equal(near, lattice.adjacency)
    steps = np.where(np.eye(lattice.units, dtype=bool), 0.0, np.where(near, 1.0, np.inf))
    for middle in range(lattice.units):
        steps = np.minimum(steps, steps[:, [middle]] + steps[[middle], :])
    assert np.array_equal(steps, lattice.steps)


def test_inner_hexagonal_units_have_six_neighbors_all_one_apart() -> None:
    lattice = Lattice(5, 5)
    assert lattice.neighbors(12) == (6, 7, 11, 13, 16, 17) or len(lattice.neighbors(12)) == 6
    assert np.allclose(lattice.squared_distances[12, list(lattice.neighbors(12))], 1.0)


def test_a_lattice_of_no_units_or_too_many_is_refused() -> None:
    with pytest.raises(MapError, match="0 x 5"):
        Lattice(0, 5)
    with pytest.raises(MapError, match="10000"):
        Lattice(1000, 1000)


# -- the thesis's schedules, values read off table 4.8 and 4.9


def test_configuration_1_falls_linearly_then_jumps_to_its_floor() -> None:
    rates = METRIC_1.rates()
    assert rates[0] == pytest.approx(0.4)
    assert rates[500] == pytest.approx(0.4 - 0.3 * 0.5)
    assert rates[999] > 0.1
    assert rates[1000] == rates[4999] == 0.01
    assert METRIC_1.radii()[999] == 1.0
    assert METRIC_1.radii()[1000] == 0.0


def test_configuration_2_follows_the_power_series() -> None:
    assert METRIC_2.rates()[500] == pytest.approx(0.1 * (0.01 / 0.1) ** 0.5)
    assert PERCEPTUAL_2.rates()[250] == pytest.approx(0.3 * (0.01 / 0.3) ** 0.5)
    assert PERCEPTUAL_2.rates()[500] == 0.01
    assert METRIC_2.radii()[0] == 3.0


@pytest.mark.parametrize("config", [METRIC_1, METRIC_2])
def test_a_run_that_only_the_cap_ends_says_so(config: OnlineConfig) -> None:
    som = SOM.train(places(), config, np.random.default_rng(0))
    assert som.training is not None
    assert som.training.steps == 5000
    assert som.training.capped


def test_training_stops_once_the_mean_move_is_small() -> None:
    same = np.full((4, 2), 0.5)
    som = SOM.train(same, METRIC_1, np.random.default_rng(0))
    assert som.training is not None
    assert not som.training.capped
    assert som.training.steps < 5000


# -- online training, checked against a plain transcription


def transcription(
    lattice: Lattice,
    weights: NDArray[np.float64],
    samples: NDArray[np.float64],
    config: OnlineConfig,
    seed: int,
) -> NDArray[np.float64]:
    """Section 3.4.3, steps 2 and 3, unit by unit."""
    weights = weights.copy()
    order = np.random.default_rng(seed).integers(len(samples), size=config.max_steps)
    for index, rate, radius in zip(order, config.rates(), config.radii(), strict=True):
        sample = samples[index]
        winner = int(np.argmin([np.linalg.norm(sample - w) for w in weights]))
        for unit in range(lattice.units):
            if config.neighborhood == "bubble":
                gain = 1.0 if lattice.steps[winner, unit] <= radius else 0.0
            else:
                gain = math.exp(-lattice.squared_distances[winner, unit] / (2.0 * radius**2))
            weights[unit] += rate * gain * (sample - weights[unit])
    return weights


@pytest.mark.parametrize("neighborhood", ["bubble", "gaussian"])
@pytest.mark.parametrize("dims", [2, 200])
def test_both_forms_of_online_training_equal_a_plain_transcription(neighborhood: str, dims: int) -> None:
    samples = np.random.default_rng(1).uniform(0.0, 1.0, (15, dims))
    start = np.random.default_rng(2).uniform(-0.3, 0.3, (12, dims))
    config = OnlineConfig(
        steps=120,
        max_steps=200,
        rate=0.5,
        neighborhood=neighborhood,  # type: ignore[arg-type]
        radius=1.0 if neighborhood == "bubble" else 2.0,
        stop_delta=0.0,
    )
    som = SOM(3, 4, weights=start).partial_fit(samples, config, np.random.default_rng(7))
    expected = transcription(som.lattice, start, samples, config, 7)
    assert np.abs(som.weights - expected).max() < 1e-12


def test_online_training_without_a_generator_is_refused() -> None:
    with pytest.raises(MapError, match="Generator"):
        SOM.train(places(), METRIC_1)


# -- batch training


def test_batch_training_needs_no_seed_and_repeats_to_the_bit() -> None:
    assert np.array_equal(SOM.train(places()).weights, SOM.train(places()).weights)
    assert np.array_equal(SOM.train(views()).weights, SOM.train(views()).weights)


def test_gram_and_direct_batch_training_agree() -> None:
    samples = views(count=40, dims=30)  # more samples than dimensions: direct
    wide = np.hstack([samples, np.zeros((40, 60))])  # fewer: Gram form, same geometry
    direct, gram = SOM.train(samples), SOM.train(wide)
    assert np.abs(gram.weights[:, :30] - direct.weights).max() < 1e-10
    assert np.abs(gram.weights[:, 30:]).max() < 1e-12


@pytest.mark.parametrize("seed", range(5))
def test_batch_beats_configuration_1_in_both_kinds(seed: int) -> None:
    for samples, config in ((places(30, seed=seed), METRIC_1), (views(seed=seed), PERCEPTUAL_1)):
        thesis = SOM.train(samples, config, np.random.default_rng(seed))
        assert SOM.train(samples).quantization_error(samples) <= 0.85 * thesis.quantization_error(samples)


@pytest.mark.parametrize("seed", range(5))
def test_batch_tears_no_more_samples_than_configuration_1_over_many_rooms(seed: int) -> None:
    rooms = [places(40, seed=100 * seed + room) for room in range(8)]
    thesis = [SOM.train(room, METRIC_1, np.random.default_rng(seed)) for room in rooms]
    errors = [
        (SOM.train(room).topographic_error(room), som.topographic_error(room))
        for room, som in zip(rooms, thesis, strict=True)
    ]
    ours, theirs = np.mean(errors, axis=0)
    assert ours <= theirs


def test_of_several_starts_one_is_kept_that_fits_no_worse_before_filling() -> None:
    samples = places(40, seed=3)
    costs = []
    for starts in (1, 4):
        som = SOM.train(samples, BatchConfig(starts=starts, fill=False))
        costs.append(som.quantization_error(samples) * (1.0 + 4.0 * som.topographic_error(samples)))
    assert costs[1] <= costs[0] + 1e-12


@pytest.mark.parametrize("starts", [0, 5])
def test_a_number_of_starts_that_there_is_not_is_refused(starts: int) -> None:
    with pytest.raises(MapError, match="from 1 to 4"):
        BatchConfig(starts=starts)


def test_units_too_far_from_every_winner_to_be_reached_follow_the_nearest() -> None:
    som = SOM.train([[0.0], [1.0]], BatchConfig(passes=1, radius_end=0.3, fill=False), rows=1, cols=40)
    assert np.isfinite(som.weights).all()
    assert set(np.round(som.weights[:, 0], 6)) >= {0.0, 1.0}


def test_continued_training_follows_new_samples() -> None:
    som = SOM.train(places())
    moved = places() + 5.0
    before = som.quantization_error(moved)
    som.partial_fit(moved, BatchConfig(passes=1, radius=0.3))
    assert som.quantization_error(moved) < 0.1 * before


@settings(max_examples=40, deadline=None)
@given(
    rows=st.integers(1, 4),
    cols=st.integers(1, 4),
    count=st.integers(1, 12),
    dims=st.sampled_from([1, 2, 3, 60]),
    seed=st.integers(0, 99),
)
def test_any_shape_trains_to_finite_weights_within_the_samples_hull(
    rows: int, cols: int, count: int, dims: int, seed: int
) -> None:
    samples = np.random.default_rng(seed).normal(size=(count, dims))
    som = SOM.train(samples, BATCH, rows=rows, cols=cols)
    assert (som.weights <= samples.max(axis=0) + 1e-9).all()
    assert (som.weights >= samples.min(axis=0) - 1e-9).all()
    assert som.hits(samples).sum() == count
    assert 0.0 <= som.topographic_error(samples) <= 1.0


def test_one_dimensional_maps_order_a_line() -> None:
    line = np.linspace(0.0, 1.0, 40)[:, None]
    som = SOM.train(line, rows=1, cols=8)
    steps = np.diff(som.weights[:, 0])
    assert (steps > 0).all() or (steps < 0).all()


# -- asking a trained map


def test_kept_edges_are_lattice_edges_between_first_and_second_units() -> None:
    samples = places(40)
    som = SOM.train(samples)
    expected = set()
    for row in som.transform(samples):
        first, second = np.argsort(row, kind="stable")[:2]
        if som.lattice.adjacency[first, second]:
            expected.add((min(first, second), max(first, second)))
    assert {(int(i), int(j)) for i, j in som.kept_edges(samples)} == expected


def test_locate_best_takes_the_best_unit_that_has_a_value() -> None:
    som = SOM(1, 3, weights=[[0.0], [1.0], [2.0]])
    values = np.array([[10.0], [np.nan], [30.0]])
    assert som.locate([0.9], values).tolist() == [10.0]
    assert som.locate([1.6], values, "nearest", k=1).tolist() == [30.0]
    assert 10.0 < som.locate([0.9], values, "radial")[0] < 30.0


def test_locate_radial_is_the_midpoint_halfway_between_two_units() -> None:
    som = SOM(1, 2, weights=[[0.0], [1.0]])
    assert som.locate([0.5], [[0.0, 0.0], [2.0, 4.0]], "radial") == pytest.approx([1.0, 2.0])


def test_nearest_orders_the_k_best() -> None:
    som = SOM(1, 3, weights=[[0.0], [1.0], [2.0]])
    units, distances = som.nearest([1.8], 2)
    assert units.tolist() == [2, 1]
    assert distances == pytest.approx([0.2, 0.8])


@pytest.mark.parametrize(
    ("samples", "message"),
    [([], "shape"), ([[np.nan, 0.0]], "not finite"), ([[[1.0]]], "shape"), ([[np.inf, 1.0]], "not finite")],
)
def test_bad_samples_are_refused(samples: list[float], message: str) -> None:
    with pytest.raises(MapError, match=message):
        SOM.train(samples)


def test_an_untrained_map_says_so() -> None:
    with pytest.raises(NotTrainedError):
        SOM().winners([[0.0, 0.0]])


def test_weights_of_the_wrong_shape_or_not_finite_are_refused() -> None:
    with pytest.raises(MapError, match=r"\(25, dims\)"):
        SOM(weights=[[0.0, 1.0]])
    with pytest.raises(MapError, match="not finite"):
        SOM(1, 1, weights=[[np.nan]])
    with pytest.raises(MapError, match="dimensions"):
        SOM(1, 1, weights=[[0.0, 1.0]]).winners([[1.0]])


def test_weights_cannot_be_changed_from_outside() -> None:
    som = SOM.train(places())
    with pytest.raises(ValueError, match="read-only"):
        som.weights[0, 0] = 9.0
