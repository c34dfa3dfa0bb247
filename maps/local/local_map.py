"""The local map of a global node: a metric SOM of its free space, a perceptual SOM of the views there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import hypot
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import networkx as nx
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MapError, NoPathError, UnknownNodeError
from ..planning import shortest_path
from ..som.lattice import Floats, Ints, frozen
from .content import LocalMapContent

if TYPE_CHECKING:
    from ..som.som import SOM, Method
    from .config import LocalMapConfig


class Trainer(Protocol):
    """Trains the content of a local map. `training` lies above, so it is told here what does."""

    def __call__(
        self,
        positions: ArrayLike,
        panorama_positions: ArrayLike | None,
        panoramas: ArrayLike | None,
        config: LocalMapConfig | None,
        rng: np.random.Generator | None,
        entry_heading: float,
        entry_panorama: ArrayLike | None,
    ) -> LocalMapContent:
        """See `LocalMap.build`."""
        ...


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


class LocalMap:
    """The space around one global node. Local frame: origin at the node, x axis along the entry heading, m.

    metric: SOM of free space, weights (units, 2) m. hits: (units,) samples won by each metric unit. edges:
    (E, 2) kept lattice edges, i < j. blocked: the edges found blocked. perceptual: SOM of views, weights
    (units, 1024), or None. view_positions: (units, 2) m where those views were taken, NaN where none.
    view_error: distance up to which a view passes for one taken nearby. entry_panorama: (4, 16, 16) at the
    node.

    A map read from a file loads its content on first use and may then raise MapFileError. Until then it holds
    nothing open; pickled it is whole.
    """

    trainer: ClassVar[Trainer]

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
        config: LocalMapConfig | None = None,
        rng: np.random.Generator | None = None,
        *,
        entry_heading: float = 0.0,
        entry_panorama: ArrayLike | None = None,
    ) -> Self:
        """Trains both SOMs on what local exploration sampled (section 3.4.3).

        positions: (N, 2) m, local frame. panorama_positions: (K, 2) m; panoramas: (K, 4, 16, 16). config:
        None for that of profile `default`. The rng is needed by the thesis's configurations alone.

        Raises: MapError.
        """
        heading = float(entry_heading)
        return cls(
            cls.trainer(positions, panorama_positions, panoramas, config, rng, heading, entry_panorama)
        )

    def __repr__(self) -> str:
        """What there is in it; an unread one is not read for that."""
        if self._content is None:
            return "LocalMap(not read yet)"
        views = "no views" if self.perceptual is None else f"{self.perceptual.units} views"
        hit = int((self.hits > 0).sum())
        return f"LocalMap({hit} of {self.metric.units} units hit, {len(self.edges)} edges, {views})"

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """A copy with blocked edges of its own; the content, which never changes, is shared."""
        twin = type(self)(self._content if self._load is None else self._load)  # type: ignore[arg-type]
        twin._blocked = None if self._blocked is None else set(self._blocked)
        return twin

    def __reduce__(self) -> tuple[type[Self], tuple[LocalMapContent]]:
        """Pickled whole: whoever gets it need not have the file."""
        return type(self), (self.content,)

    @property
    def content(self) -> LocalMapContent:
        """Everything there is to store, blocked edges up to date; loads it when need be."""
        if self._content is None:
            assert self._load is not None
            self._content, self._load = self._load(), None
        if self._blocked is not None:
            self._content = replace(self._content, blocked=frozenset(self._blocked))
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
