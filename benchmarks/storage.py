"""Measures map files: opening, committing a node, size."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.storage.map_file import MapFile

from .figures import Figure, median_seconds

VIEWS = 30
MEGABYTE = 1e6


def full_local_map(rng: np.random.Generator) -> LocalMap:
    """A local map of made-up samples, as large as real ones: 25 units of 1,024 values, an entry panorama."""
    places, views = rng.uniform(-0.1, 0.1, (60, 2)), rng.uniform(0.0, 1.0, (VIEWS, 4, 16, 16))
    return LocalMap.build(places, places[:VIEWS], views, entry_panorama=views[0])


def ring(nodes: int, local_map: LocalMap) -> HybridMap:
    """A made-up map of so many nodes along one wall, each with that local map."""
    hybrid = HybridMap()
    for node in range(nodes):
        hybrid.add_node(node=node, corner="concave", turn=1.5, local_map=local_map)
        if node:
            hybrid.add_arc(node - 1, node, "right", 0.4, 1e-4)
    hybrid.add_arc(nodes - 1, 0, "right", 0.4, 1e-4)
    return hybrid


def storage_figures() -> Iterator[Figure]:
    """All of them, as they are measured. Needs 100 MB in the folder for temporary files.

    Opening is told in the processor's time: the file is in memory by then. Committing waits for the disk.
    """
    rng = np.random.default_rng(0)
    whole = full_local_map(rng)
    bare = LocalMap.build(rng.uniform(-0.1, 0.1, (30, 2)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for nodes, limit in ((1_000, 0.2), (20_000, 2.0)):
            path = folder / f"{nodes}.tolman"
            ring(nodes, bare).save(path)
            seconds = median_seconds(lambda path=path: HybridMap.load(path), 5)  # type: ignore[misc]
            yield Figure(f"map of {nodes} nodes: open", seconds, "s", limit)
        yield from _commits(folder / "20000.tolman", whole)
        path = folder / "27.tolman"
        ring(27, whole).save(path)
        yield Figure("map of 27 nodes with local maps: size", path.stat().st_size / MEGABYTE, "MB", 4.0)


def _commits(path: Path, local_map: LocalMap, times: int = 200) -> Iterator[Figure]:
    """Commits nodes with whole local maps, two arcs, state and truth, as a mapping does."""
    file = MapFile.resume(path)
    hybrid, first = file.map, len(file.map.graph)
    durations = np.empty(times)
    for index in range(times):
        node = first + index
        hybrid.add_node(node=node, corner="concave", turn=1.5, local_map=local_map)
        hybrid.add_arc(node - 1, node, "right", 0.4, 1e-4)
        start = time.perf_counter()
        file.append(hybrid, node, state={"odometry": [0.1] * 200}, truth={"pose": [0.0, 1.0, 2.0]})
        durations[index] = time.perf_counter() - start
    file.seal()
    yield Figure(
        f"map of {first} nodes: commit one more, median", 1e3 * float(np.median(durations)), "ms", 5.0
    )
    late = 1e3 * float(np.percentile(durations, 99.0))
    yield Figure(f"map of {first} nodes: commit one more, 99th percentile", late, "ms")
