"""Measures SOM training: time beside MiniSom's, fit beside the thesis's configuration 1, free space."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from tolman.maps.local.local_map import LocalMap
from tolman.maps.som.schedules import METRIC_1, METRIC_2, PERCEPTUAL_1, PERCEPTUAL_2, OnlineConfig
from tolman.maps.som.som import SOM

from .figures import Figure, median_seconds
from .places import KINDS, PlaceSamples, crosses, sample_place

PLACES = 30
SIZE = 0.25
"""Meters: what metric samples are divided by, as local maps do."""

THESIS_STEPS, FEW_STEPS = 5000, 1500
"""Steps of MiniSom's training: those the thesis's configurations take up to their cap, and fewer."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Kind:
    """One of a local map's two SOMs: its samples a place, and what is expected of it; seconds, ratios."""

    name: str
    samples: Sequence[Floats]
    configurations: tuple[OnlineConfig, OnlineConfig]
    batch_limit: float
    online_limits: tuple[float, float]


def kinds(places: Sequence[PlaceSamples]) -> tuple[Kind, Kind]:
    """Metric and perceptual samples of the places."""
    metric = [place.local(place.positions) / SIZE + 0.5 for place in places]
    views = [place.views.reshape(len(place.views), -1) for place in places]
    return (
        Kind("metric", metric, (METRIC_1, METRIC_2), 0.002, (0.06, 0.12)),
        Kind("perceptual", views, (PERCEPTUAL_1, PERCEPTUAL_2), 0.003, (0.06, 0.12)),
    )


def som_figures() -> Iterator[Figure]:
    """All of them, as they are measured."""
    places = [sample_place(seed) for seed in range(PLACES)]
    for kind in kinds(places):
        yield from _times(kind)
        yield from _fit(kind)
    yield from _free_space(places)


def _times(kind: Kind) -> Iterator[Figure]:
    """Times on the place with the most samples."""
    data = max(kind.samples, key=len)
    what = f"{kind.name} SOM, {len(data)} samples"
    ours = median_seconds(lambda: SOM.train(data), 100)
    yield Figure(f"{what}: batch", 1e3 * ours, "ms", 1e3 * kind.batch_limit)
    for number, (config, limit) in enumerate(zip(kind.configurations, kind.online_limits, strict=True), 1):

        def online(config: OnlineConfig = config) -> SOM:
            return SOM.train(data, config, np.random.default_rng(0))

        yield Figure(
            f"{what}: configuration {number} online", 1e3 * median_seconds(online, 5), "ms", 1e3 * limit
        )
    minisom = _minisom()
    if minisom is None:
        return
    for steps, target in ((THESIS_STEPS, 100.0), (FEW_STEPS, None)):
        theirs = median_seconds(lambda steps=steps: _train_minisom(minisom, data, steps), 3)  # type: ignore[misc]
        ours = median_seconds(lambda: SOM.train(data), 100)
        yield Figure(
            f"{what}: MiniSom's train(), {steps} steps, over batch", theirs / ours, "x", target, True
        )


def _minisom() -> Any:
    """MiniSom's module, or None where it is not installed (it comes with the test dependencies)."""
    try:
        return importlib.import_module("minisom")
    except ImportError:
        print("MiniSom is not installed: `make test` installs it; the comparison is left out")
        return None


def _train_minisom(minisom: Any, data: Floats, steps: int) -> None:
    som = minisom.MiniSom(5, 5, data.shape[1], sigma=1.5, topology="hexagonal", random_seed=1)
    som.train(data, steps)


def _fit(kind: Kind) -> Iterator[Figure]:
    """Errors over all places beside configuration 1's."""
    ours: list[tuple[float, float]] = []
    theirs: list[tuple[float, float]] = []
    for seed, data in enumerate(kind.samples):
        thesis = SOM.train(data, kind.configurations[0], np.random.default_rng(seed))
        for som, errors in ((SOM.train(data), ours), (thesis, theirs)):
            errors.append((som.quantization_error(data), som.topographic_error(data)))
    mine, other = np.array(ours), np.array(theirs)
    what = f"{kind.name} SOM, {len(ours)} places"
    total = float(mine[:, 0].sum() / other[:, 0].sum())
    yield Figure(f"{what}: quantization error over configuration 1's", total, "x", 0.85)
    yield Figure(f"{what}: the same of the worst place", float((mine[:, 0] / other[:, 0]).max()), "x")
    yield Figure(f"{what}: topographic error, configuration 1", float(other[:, 1].mean()), "")
    yield Figure(f"{what}: topographic error, batch", float(mine[:, 1].mean()), "", float(other[:, 1].mean()))


def _free_space(places: Sequence[PlaceSamples]) -> Iterator[Figure]:
    """Units in obstacles, edges across walls, parts that do not hang together."""
    crossing, edges, buried, parts = dict.fromkeys(KINDS, 0), dict.fromkeys(KINDS, 0), 0, 0
    for place in places:
        local = LocalMap.build(place.local(place.positions))
        units = local.metric.weights + np.array(place.center)
        for i, j in local.edges.tolist():
            edges[place.kind] += 1
            crossing[place.kind] += crosses(place.plan, units[i], units[j])
        for unit in np.flatnonzero(local.hits > 0).tolist():
            buried += place.plan.contains(*map(float, units[unit]))
        parts += not nx.is_connected(local.free_space())
    yield Figure(f"free space, {len(places)} places: hit units in an obstacle", buried, "", 0)
    thin = [kind for kind in KINDS if "thin" in kind]
    share = 100.0 * sum(crossing[kind] for kind in thin) / sum(edges[kind] for kind in thin)
    yield Figure("free space: kept edges that cross a wall of 5 mm", share, "%", 4.0)
    rest = sum(crossing[kind] for kind in KINDS if kind not in thin)
    yield Figure("free space: kept edges that cross something else", rest, "")
    yield Figure("free space: places whose units do not hang together", parts, "")
