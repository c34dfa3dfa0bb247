"""Shortest paths by A* (algorithm 3), used on the global graph and inside the local maps."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from .errors import NoPathError

Node = TypeVar("Node", bound=Hashable)
Edge = TypeVar("Edge")


def shortest_path(
    start: Node,
    goal: Node,
    leaving: Callable[[Node], Iterable[tuple[Node, float, Edge]]],
    heuristic: Callable[[Node], float] = lambda _: 0.0,
) -> tuple[list[Edge], float]:
    """The edges of a shortest path and its length; no edges and 0 when start is goal.

    leaving(node) yields (next node, length >= 0, edge) for every edge that may be used; heuristic(node) never
    exceeds the true remaining length. Of equally short paths the one found first is taken, so the order in
    which `leaving` yields decides. Appendix 3's slips are mended: the goal is tested when taken out,
    `no path` is said only once the open set is empty, and a better way to a closed node reopens it.

    Raises: NoPathError when the goal cannot be reached.
    """
    best = {start: 0.0}
    came: dict[Node, tuple[Node, Edge]] = {}
    waiting: list[tuple[float, int, Node, float]] = [(heuristic(start), 0, start, 0.0)]
    pushed = 0
    while waiting:
        _, _, node, length = heapq.heappop(waiting)
        if node == goal:
            return _generate(came, goal, start), length
        if length > best[node]:
            continue
        for following, step, edge in leaving(node):
            candidate = length + step
            if candidate < best.get(following, float("inf")):
                best[following] = candidate
                came[following] = (node, edge)
                pushed += 1
                heapq.heappush(waiting, (candidate + heuristic(following), pushed, following, candidate))
    raise NoPathError(f"no path leads from {start} to {goal}: {len(best)} node(s) can be reached")


def _generate(came: dict[Node, tuple[Node, Edge]], goal: Node, start: Node) -> list[Edge]:
    """Algorithm 4: the edges from start to goal, walked back."""
    edges: list[Edge] = []
    node = goal
    while node != start:
        node, edge = came[node]
        edges.append(edge)
    return edges[::-1]
