from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.maps.errors import NoPathError
from tolman.maps.planning import shortest_path


@given(seed=st.integers(0, 10_000), nodes=st.integers(2, 12), density=st.floats(0.05, 0.9))
def test_paths_are_as_short_as_networkxs(seed: int, nodes: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 1.0, (nodes, 2))
    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(range(nodes))
    for a in range(nodes):
        for b in range(nodes):
            if a != b and rng.uniform() < density:
                graph.add_edge(a, b, weight=float(np.linalg.norm(points[a] - points[b])))

    def leaving(node: int) -> Iterator[tuple[int, float, int]]:
        return ((b, data["weight"], b) for _, b, data in graph.out_edges(node, data=True))

    def straight(node: int) -> float:
        return float(np.linalg.norm(points[node] - points[nodes - 1]))

    if not nx.has_path(graph, 0, nodes - 1):
        with pytest.raises(NoPathError):
            shortest_path(0, nodes - 1, leaving, straight)
        return
    path, length = shortest_path(0, nodes - 1, leaving, straight)
    assert length == pytest.approx(nx.shortest_path_length(graph, 0, nodes - 1, weight="weight"))
    steps = [0, *path]
    assert sum(graph.edges[a, b]["weight"] for a, b in pairwise(steps)) == pytest.approx(length)


def test_an_inconsistent_but_admissible_heuristic_still_gives_the_shortest_path() -> None:
    ways = {
        "s": [("a", 1.0, "sa"), ("b", 2.0, "sb")],
        "b": [("a", -0.0 + 0.5, "ba")],
        "a": [("g", 10.0, "ag")],
    }
    ways["s"] = [("a", 4.0, "sa"), ("b", 2.0, "sb")]
    guess = {"s": 0.0, "a": 0.0, "b": 10.0, "g": 0.0}
    path, length = shortest_path("s", "g", lambda node: ways.get(node, []), lambda node: guess[node])
    assert (path, length) == (["sb", "ba", "ag"], 12.5)


def test_the_path_to_where_one_is_has_no_edges() -> None:
    assert shortest_path(3, 3, lambda _: []) == ([], 0.0)
