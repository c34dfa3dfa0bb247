"""The local map of a global node: a metric SOM of its free space, a perceptual SOM of the views there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import hypot
from typing import Literal, Self

import networkx as nx
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import MapError, NoPathError, UnknownNodeError, some
from .lattice import Floats, Ints, Topology, frozen
from .online import squared_distances
from .planning import shortest_path
from .schedules import BATCH, METRIC_1, METRIC_2, PERCEPTUAL_1, PERCEPTUAL_2, Config
from .som import SOM, Method

PANORAMA_SHAPE = (4, 16, 16)
"""Views ahead, left, behind, right of the entry heading, each (16, 16) luminance in [0, 1]."""


@dataclass(frozen=True, slots=True)
class LocalMapConfig:
    """How a local map is built. size: side (m) of the square local space, centered on the node.

    association: how positions are tied to perceptual units, `midpoint` (eq. 3.32: the last sample weighs
    half) or `mean`. locating: how a position is estimated from a view (see `SOM.locate`).
    """

    rows: int = 5
    cols: int = 5
    topology: Topology = "hexagonal"
    size: float = 0.25
    metric: Config = BATCH
    perceptual: Config = BATCH
    association: Literal["mean", "midpoint"] = "mean"
    locating: Method = "radial"


_NEXT = 0.03
"""Meters up to which two samples in a row count as joined by a drive."""

DEFAULT = LocalMapConfig()
"""Profile `default`."""

THESIS_1 = LocalMapConfig(metric=METRIC_1, perceptual=PERCEPTUAL_1, association="midpoint", locating="best")
"""Tables 4.7 and 4.8, configuration 1."""

THESIS_2 = LocalMapConfig(metric=METRIC_2, perceptual=PERCEPTUAL_2, association="midpoint", locating="best")
"""Tables 4.7 and 4.8, configuration 2, the one the thesis finds the better."""


@dataclass(frozen=True, slots=True)
class LocalEstimate:
    """Where a view seems to have been taken.

    position: (2,) m, local frame. unit: the perceptual unit that responds most. distance: how far the view is
    from that unit's weights (eq. 3.33), as Euclidean distance of luminances. confidence: 1 when no farther
    than a training view is from its nearest fellow on average, falling as their ratio.
    """

    position: Floats
    unit: int
    distance: float
    confidence: float


@dataclass(frozen=True, slots=True)
class LocalMapContent:
    """All that a local map holds, as it is stored. Arrays are read-only; `LocalMap` says what they mean."""

    metric: SOM
    hits: Ints
    edges: Ints
    entry_heading: float
    perceptual: SOM | None = None
    view_positions: Floats | None = None
    view_error: float = 0.0
    entry_panorama: NDArray[np.float32] | None = None
    blocked: frozenset[tuple[int, int]] = frozenset()
    locating: Method = "best"

    def __post_init__(self) -> None:
        """Checks that the parts fit together. Raises: MapError."""
        units = self.metric.units
        if self.metric.weights.shape[1] != 2:
            raise MapError(
                f"a metric SOM of {self.metric.weights.shape[1]} dimensions: expected 2 (x, y in m)"
            )
        if self.hits.shape != (units,) or (self.hits < 0).any():
            raise MapError(f"hits of shape {self.hits.shape}: expected ({units},), none negative")
        if self.edges.ndim != 2 or self.edges.shape[1:] != (2,) or not _edges_fit(self.edges, units):
            raise MapError(f"free-space edges must be distinct pairs i < j of the {units} units")
        if (self.perceptual is None) != (self.view_positions is None):
            raise MapError("a perceptual SOM and its view positions come together or not at all")
        if self.perceptual is not None and self.view_positions is not None:
            expected = (self.perceptual.units, 2)
            if self.view_positions.shape != expected or np.isinf(self.view_positions).any():
                raise MapError(
                    f"view positions of shape {self.view_positions.shape}: expected {expected}, finite or NaN"
                )
        if self.entry_panorama is not None and self.entry_panorama.shape != PANORAMA_SHAPE:
            raise MapError(
                f"an entry panorama of shape {self.entry_panorama.shape}: expected {PANORAMA_SHAPE}"
            )
        if self.locating not in ("best", "nearest", "radial"):
            raise MapError(f"unknown way to locate {self.locating!r}; known: best, nearest, radial")
        kept = {(int(i), int(j)) for i, j in self.edges}
        if not self.blocked <= kept:
            raise MapError(f"blocked edges {some(sorted(self.blocked - kept))} are no free-space edges")


class LocalMap:
    """The space around one global node. Local frame: origin at the node, x axis along the entry heading, m.

    metric: SOM of free space, weights (units, 2) m. hits: (units,) samples won by each metric unit. edges:
    (E, 2) kept lattice edges, i < j. blocked: the edges found blocked. perceptual: SOM of views, weights
    (units, 1024), or None. view_positions: (units, 2) m where those views were taken, NaN where none.
    view_error: distance up to which a view passes for one taken nearby. entry_panorama: (4, 16, 16) at the
    node.

    A map read from a file loads its content on first use and may then raise MapFileDamagedError.
    """

    def __init__(self, content: LocalMapContent | Callable[[], LocalMapContent]) -> None:
        """Wraps a content, or a function that will load it when first asked."""
        self._content = content if isinstance(content, LocalMapContent) else None
        self._load = None if isinstance(content, LocalMapContent) else content
        self._blocked: set[tuple[int, int]] | None = None

    @classmethod
    def build(
        cls,
        positions: ArrayLike,
        panorama_positions: ArrayLike | None = None,
        panoramas: ArrayLike | None = None,
        config: LocalMapConfig = DEFAULT,
        rng: np.random.Generator | None = None,
        *,
        entry_heading: float = 0.0,
        entry_panorama: ArrayLike | None = None,
    ) -> Self:
        """Trains both SOMs on what local exploration sampled (section 3.4.3).

        positions: (N, 2) m, local frame. panorama_positions: (K, 2) m; panoramas: (K, 4, 16, 16). The rng is
        needed by the thesis's configurations alone. Raises: MapError.
        """
        places = _places(positions, "positions")
        metric = SOM(config.rows, config.cols, config.topology)
        metric.fit(places / config.size + 0.5, config.metric, rng)
        metric = SOM(config.rows, config.cols, config.topology, (metric.weights - 0.5) * config.size)
        perceptual, tied, error = _views(panorama_positions, panoramas, config, rng)
        return cls(
            LocalMapContent(
                metric=metric,
                hits=frozen(metric.hits(places)),
                edges=frozen(_free_edges(metric, places)),
                entry_heading=float(entry_heading),
                perceptual=perceptual,
                view_positions=tied,
                view_error=error,
                entry_panorama=_panorama(entry_panorama),
                locating=config.locating,
            )
        )

    @property
    def content(self) -> LocalMapContent:
        """Everything there is to store, blocked edges up to date; loads it when need be."""
        if self._content is None:
            assert self._load is not None
            self._content, self._load = self._load(), None
        if self._blocked is not None:
            known = self._content
            values = {name: getattr(known, name) for name in known.__slots__}
            self._content = LocalMapContent(**{**values, "blocked": frozenset(self._blocked)})
            self._blocked = None
        return self._content

    @property
    def metric(self) -> SOM:
        """SOM of free space; weights (units, 2) m."""
        return self.content.metric

    @property
    def hits(self) -> Ints:
        """(units,) samples won by each metric unit."""
        return self.content.hits

    @property
    def edges(self) -> Ints:
        """(E, 2) kept edges of the metric SOM, i < j."""
        return self.content.edges

    @property
    def blocked(self) -> frozenset[tuple[int, int]]:
        """The edges (i, j), i < j, found blocked."""
        return self.content.blocked

    @property
    def perceptual(self) -> SOM | None:
        """SOM of the views, weights (units, 1024), or None."""
        return self.content.perceptual

    @property
    def view_positions(self) -> Floats | None:
        """(units, 2) m, where each perceptual unit's views were taken; NaN where none."""
        return self.content.view_positions

    @property
    def view_error(self) -> float:
        """Distance up to which a view passes for one taken nearby."""
        return self.content.view_error

    @property
    def entry_heading(self) -> float:
        """Heading (rad, map frame) on entry: the direction of the local x axis."""
        return self.content.entry_heading

    @property
    def entry_panorama(self) -> NDArray[np.float32] | None:
        """(4, 16, 16) taken at the node on entry, or None."""
        return self.content.entry_panorama

    @property
    def locating(self) -> Method:
        """How positions are estimated from views."""
        return self.content.locating

    def locate(self, panorama: ArrayLike, method: Method | None = None) -> LocalEstimate:
        """Where a panorama (4, 16, 16), views in the entry heading's frame, was taken (section 3.5.2).

        Raises: MapError without a perceptual SOM.
        """
        if self.perceptual is None or self.view_positions is None:
            raise MapError("this local map has no perceptual SOM to locate by")
        view = np.asarray(panorama, dtype=np.float64).ravel()
        position = self.perceptual.locate(view, self.view_positions, method or self.locating)
        unit, distance = self.perceptual.nearest(view)
        apart = float(distance[0])
        confidence = 1.0 if apart <= self.view_error else self.view_error / apart
        return LocalEstimate(frozen(position), int(unit[0]), apart, confidence)

    def position(self, unit: int) -> tuple[float, float]:
        """x, y (m, local frame) of a metric unit. Raises: UnknownNodeError."""
        if not 0 <= unit < self.metric.units:
            raise UnknownNodeError(f"no metric unit {unit}: this map has 0 to {self.metric.units - 1}")
        x, y = self.metric.weights[unit]
        return float(x), float(y)

    def nearest_unit(self, x: float = 0.0, y: float = 0.0) -> int:
        """The hit metric unit nearest to x, y (m, local frame): where navigation enters the map."""
        away = np.hypot(self.metric.weights[:, 0] - x, self.metric.weights[:, 1] - y)
        return int(np.where(self.hits > 0, away, np.inf).argmin())

    def block(self, i: int, j: int) -> None:
        """Marks the edge between two metric units as blocked. Raises: UnknownNodeError."""
        self._set_blocked(i, j, True)

    def unblock(self, i: int, j: int) -> None:
        """Takes a mark of `block` back. Raises: UnknownNodeError."""
        self._set_blocked(i, j, False)

    def _set_blocked(self, i: int, j: int, value: bool) -> None:
        edge = (min(i, j), max(i, j))
        if edge not in self._kept():
            raise UnknownNodeError(f"no free-space edge between units {i} and {j} of this local map")
        if self._blocked is None:
            self._blocked = set(self.content.blocked)
        (self._blocked.add if value else self._blocked.discard)(edge)

    def path(self, start: int, goal: int) -> list[int]:
        """Metric units from start to goal, both included: A* over the edges that are not blocked.

        Raises: UnknownNodeError, NoPathError.
        """
        at_goal = self.position(goal)
        self.position(start)
        blocked = self.blocked
        leaving: dict[int, list[tuple[int, float, int]]] = {}
        for i, j in self._kept():
            if (i, j) not in blocked:
                length = _distance(self.position(i), self.position(j))
                leaving.setdefault(i, []).append((j, length, j))
                leaving.setdefault(j, []).append((i, length, i))

        def following(unit: int) -> Iterator[tuple[int, float, int]]:
            return iter(leaving.get(unit, ()))

        try:
            units, _ = shortest_path(
                start, goal, following, lambda unit: _distance(self.position(unit), at_goal)
            )
        except NoPathError:
            raise NoPathError(f"metric unit {goal} cannot be reached from {start}: no edges free") from None
        return [start, *units]

    def free_space(self) -> nx.Graph[int]:
        """Hit units and kept edges; nodes carry x, y (m) and hits, edges distance (m) and blocked."""
        graph: nx.Graph[int] = nx.Graph()
        for unit in np.flatnonzero(self.hits > 0).tolist():
            x, y = self.position(unit)
            graph.add_node(unit, x=x, y=y, hits=int(self.hits[unit]))
        blocked = self.blocked
        for i, j in self._kept():
            graph.add_edge(
                i, j, distance=_distance(self.position(i), self.position(j)), blocked=(i, j) in blocked
            )
        return graph

    def _kept(self) -> list[tuple[int, int]]:
        return [(i, j) for i, j in self.edges.tolist()]


def _distance(one: tuple[float, float], other: tuple[float, float]) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])


def _free_edges(metric: SOM, places: Floats) -> Ints:
    """(E, 2) edges of free space: those of the lattice that samples keep, and those that were driven.

    places: (n, 2) m, in the order in which they were sampled. Two samples in a row that are near each other
    have free space between them, so their units are joined even where the lattice has no such edge.
    """
    kept = metric.kept_edges(places)
    won = metric.winners(places)
    apart = np.linalg.norm(np.diff(places, axis=0), axis=1)
    driven = np.column_stack((won[:-1], won[1:]))[(apart <= _NEXT) & (won[:-1] != won[1:])]
    return np.unique(np.vstack((kept, np.sort(driven, axis=1))).astype(np.int64), axis=0)


def _edges_fit(edges: Ints, units: int) -> bool:
    inside = bool(((edges >= 0) & (edges < units)).all()) and bool((edges[:, 0] < edges[:, 1]).all())
    return inside and len(np.unique(edges, axis=0)) == len(edges)


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
