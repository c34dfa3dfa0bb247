"""The temporary rigid graph that leads the exploration of local space (section 3.4.3)."""

from __future__ import annotations

import math
from itertools import product

import networkx as nx

from ...maps.errors import NoPathError
from ...maps.planning import shortest_path

Cell = tuple[int, int]
"""(row, column) of a node of the rigid graph."""


class RigidGraph:
    """A hexagonal lattice of places to visit, centered on the global node; x is the entry heading.

    Neighbors are `spacing` m apart; every other column is shifted by half of it. Arcs found blocked are
    removed; what cannot be reached any more is given up.
    """

    def __init__(self, rows: int = 5, columns: int = 5, spacing: float = 0.05) -> None:
        """Raises: ValueError unless rows and columns are odd, so that one node is the center."""
        if rows % 2 == 0 or columns % 2 == 0:
            raise ValueError(
                f"the rigid graph needs odd rows and columns to have a center, not {rows}x{columns}"
            )
        self.rows, self.columns = rows, columns
        self.center: Cell = (rows // 2, columns // 2)
        pitch = spacing * math.sqrt(0.75)
        self.places: dict[Cell, tuple[float, float]] = {
            (r, c): (
                (c - columns // 2) * pitch,
                (r - rows // 2 + 0.5 * ((c - columns // 2) % 2)) * spacing,
            )
            for r, c in product(range(rows), range(columns))
        }
        self.graph: nx.Graph = nx.Graph()
        self.graph.add_nodes_from(self.places)
        self._driven: nx.Graph = nx.Graph()
        cells = list(self.places)
        for i, a in enumerate(cells):
            for b in cells[i + 1 :]:
                if self.distance(a, b) < 1.1 * spacing:
                    self.graph.add_edge(a, b)

    def distance(self, a: Cell, b: Cell) -> float:
        """Euclidean distance (m) between two nodes."""
        (ax, ay), (bx, by) = self.places[a], self.places[b]
        return math.hypot(ax - bx, ay - by)

    def order(self, strategy: str) -> list[Cell]:
        """The nodes row by row or column by column, back and forth (fig. 3.21)."""
        rows, columns = range(self.rows), range(self.columns)
        if strategy == "rows":
            return [(r, c) for r in rows for c in columns[:: -1 if r % 2 else 1]]
        if strategy == "columns":
            return [(r, c) for c in columns for r in rows[:: -1 if c % 2 else 1]]
        raise ValueError(f"unknown exploration strategy {strategy!r}; known: rows, columns")

    def path(self, start: Cell, goal: Cell) -> list[Cell] | None:
        """The shortest way (A*) not known to be blocked, without `start`; None if there is none."""
        try:
            path, _ = shortest_path(
                start,
                goal,
                lambda cell: ((neighbor, 1.0, neighbor) for neighbor in self.graph[cell]),
                lambda cell: self.distance(cell, goal),
            )
        except NoPathError:
            return None
        return path

    def way_back(self, start: Cell, goal: Cell) -> list[Cell] | None:
        """The shortest way over arcs that were driven, without `start`; None if there is none."""
        if start not in self._driven or goal not in self._driven:
            return None if start != goal else []
        path: list[Cell] = nx.shortest_path(self._driven, start, goal)
        return path[1:]

    def drove(self, a: Cell, b: Cell) -> None:
        """Remembers that the arc between two neighbors is free: it was driven."""
        if a != b:
            self._driven.add_edge(a, b)

    def was_driven(self, a: Cell, b: Cell) -> bool:
        """Whether the arc between two neighbors was driven; within one place there is nothing to drive."""
        return a == b or bool(self._driven.has_edge(a, b))

    def block(self, a: Cell, b: Cell) -> None:
        """Remembers that an obstacle parts two neighbors."""
        if self.graph.has_edge(a, b):
            self.graph.remove_edge(a, b)
