"""Trains local maps: both SOMs, the edges of free space, the positions tied to views (section 3.4.3)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...world.robot import EPUCK
from ..errors import MapError
from ..som.lattice import Floats, Ints, frozen
from ..som.online import squared_distances
from ..som.som import SOM
from .config import DEFAULT, LocalMapConfig
from .content import LocalMapContent
from .local_map import LocalMap

NO_WALL_FITS = 2.0 * EPUCK.body_radius - 0.01
"""Meters. Two places where the robot's center was, nearer than its body is wide, have no wall between them,
however thin: it would have been within the body at one of them. Less 1 cm for what positions are off by."""

COVERED = EPUCK.body_radius - 0.005
"""Meters around a place where the robot's center was: the body covered it, so nothing stands there."""


def train(
    positions: ArrayLike,
    panorama_positions: ArrayLike | None,
    panoramas: ArrayLike | None,
    config: LocalMapConfig | None,
    rng: np.random.Generator | None,
    entry_heading: float,
    entry_panorama: ArrayLike | None,
) -> LocalMapContent:
    """What `LocalMap.build` wraps; see there. Raises: MapError."""
    config = DEFAULT if config is None else config
    places = _places(positions, "positions")
    metric = SOM(config.rows, config.cols, config.topology)
    metric.fit(places / config.size + 0.5, config.metric, rng)
    metric = SOM(config.rows, config.cols, config.topology, (metric.weights - 0.5) * config.size)
    if config.grounded:
        metric = grounded(metric, places)
    perceptual, tied, error = _views(panorama_positions, panoramas, config, rng)
    return LocalMapContent(
        metric=metric,
        hits=frozen(metric.hits(places)),
        edges=frozen(free_edges(metric, places)),
        entry_heading=float(entry_heading),
        perceptual=perceptual,
        view_positions=tied,
        view_error=error,
        entry_panorama=_panorama(entry_panorama),
        locating=config.locating,
    )


def grounded(metric: SOM, places: Floats) -> SOM:
    """The SOM with each unit that samples hit moved onto one of them if the body has not been where it is.

    The mean of samples from both sides of a thin wall may lie within it. places: (n, 2) m.
    """
    weights = np.array(metric.weights, dtype=np.float64)
    for _ in range(metric.units):
        won = metric.winners(places)
        away = np.sqrt(squared_distances(places, weights))
        astray = [unit for unit in np.unique(won).tolist() if away[:, unit].min() > COVERED]
        if not astray:
            break
        for unit in astray:
            weights[unit] = places[np.where(won == unit, away[:, unit], np.inf).argmin()]
        metric = SOM(metric.rows, metric.cols, metric.topology, weights)
    return metric


def free_edges(metric: SOM, places: Floats) -> Ints:
    """(E, 2) edges of free space, i < j, between units that samples hit; places: (n, 2) m, in order of time.

    Those of the lattice that join some sample's best and second-best unit, and those between the units of
    two samples in a row. Either way only where samples of both lie so near that no wall fits between. Parts
    that this leaves apart are joined by the nearest samples of both, on the same condition.
    """
    won = metric.winners(places)
    apart = squared_distances(places, places)
    near = apart < NO_WALL_FITS**2
    member = won[:, None] == np.arange(metric.units)
    joined = (member.T.astype(np.float64) @ near @ member) > 0.0
    kept = metric.kept_edges(places)
    driven = np.sort(np.column_stack((won[:-1], won[1:])), axis=1)
    driven = driven[near[np.arange(len(places) - 1), np.arange(1, len(places))]]
    edges = np.vstack((kept, driven)).astype(np.int64)
    edges = edges[joined[edges[:, 0], edges[:, 1]] & (edges[:, 0] < edges[:, 1])]
    return np.unique(np.vstack((edges, _bridges(edges, won, np.where(near, apart, np.inf)))), axis=0)


def _bridges(edges: Ints, won: Ints, apart: Floats) -> Ints:
    """(B, 2) edges between the units `won` by the nearest samples that join parts `edges` leave apart.

    apart: (n, n) squared distances between the samples, infinite where a wall may stand between.
    """
    part = np.arange(int(won.max()) + 1)
    for i, j in edges.tolist():
        part[part == part[j]] = part[i]
    found: list[tuple[int, int]] = []
    while True:
        between = np.where(part[won][:, None] != part[won], apart, np.inf)
        i, j = (int(won[at]) for at in np.unravel_index(between.argmin(), between.shape))
        if not np.isfinite(between.min()):
            return np.array(found, dtype=np.int64).reshape(-1, 2)
        found.append((min(i, j), max(i, j)))
        part[part == part[j]] = part[i]


def _places(values: ArrayLike, name: str) -> Floats:
    places = np.asarray(values, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 2 or not len(places) or not np.isfinite(places).all():
        raise MapError(f"{name} of shape {places.shape}: expected (n, 2) finite m, at least one")
    return places


def _panorama(value: ArrayLike | None) -> NDArray[np.float32] | None:
    return None if value is None else frozen(np.array(value, dtype=np.float32))


def _views(
    positions: ArrayLike | None,
    panoramas: ArrayLike | None,
    config: LocalMapConfig,
    rng: np.random.Generator | None,
) -> tuple[SOM | None, Floats | None, float]:
    """The perceptual SOM in single precision, the positions tied to its units, its mean training distance."""
    if positions is None or panoramas is None or not len(np.asarray(panoramas)):
        return None, None, 0.0
    places = _places(positions, "panorama positions")
    views = np.asarray(panoramas, dtype=np.float64)
    if len(views) != len(places):
        raise MapError(f"{len(views)} panoramas at {len(places)} positions: expected one position each")
    views = views.reshape(len(views), -1)
    trained = SOM(config.rows, config.cols, config.topology).fit(views, config.perceptual, rng)
    som = SOM(config.rows, config.cols, config.topology, trained.weights.astype(np.float32))
    tied = tie_positions(som.winners(views), places, som.units, config.association)
    return som, frozen(tied), _view_error(som, views)


def _view_error(som: SOM, views: Floats) -> float:
    """How far a view taken nearby may be: from its unit or its nearest fellow, the larger mean."""
    if len(views) == 1:
        return som.quantization_error(views)
    apart = squared_distances(views, views)
    np.fill_diagonal(apart, np.inf)
    return max(som.quantization_error(views), float(np.sqrt(apart.min(axis=1)).mean()))


def tie_positions(
    winners: Iterable[int], places: Floats, units: int, association: Literal["mean", "midpoint"]
) -> Floats:
    """(units, 2) m: the place tied to each perceptual unit, NaN where none won; eq. 3.32 for `midpoint`."""
    tied = np.full((units, 2), np.nan)
    count = np.zeros(units)
    for unit, place in zip(winners, places, strict=True):
        count[unit] += 1
        if count[unit] == 1:
            tied[unit] = place
        else:
            weight = 0.5 if association == "midpoint" else 1.0 / count[unit]
            tied[unit] += weight * (place - tied[unit])
    return tied


LocalMap.trainer = staticmethod(train)
