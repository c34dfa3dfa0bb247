"""Made-up mappings for the torture campaigns, and a digest of all that a map file holds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from tolman.maps import HybridMap, LocalMap, MapFile, MapMeta, read_truth
from tolman.maps.storage.map_file import read_state
from tolman.maps.storage.packing import pack_local_map


def local_map(rng: np.random.Generator, views: int = 8) -> LocalMap:
    """A local map of made-up samples; the generator decides all of it."""
    places = rng.uniform(-0.1, 0.1, (30, 2))
    panoramas = rng.uniform(0.0, 1.0, (views, 4, 16, 16))
    return LocalMap.build(places, places[:views], panoramas, entry_panorama=panoramas[0])


def map_made_up_world(
    path: Path, nodes: int, seed: int, saved: Callable[[int], object] = lambda _: None, resume: bool = False
) -> None:
    """Maps a ring of made-up nodes into a file, or goes on with one; calls saved(node) after each commit."""
    file = (
        MapFile.resume(path)
        if resume
        else MapFile.create(path, MapMeta(world="made-up", seed=seed), force=True)
    )
    rng = np.random.default_rng(seed)
    if isinstance(file.state, dict):
        rng.bit_generator.state = file.state["rng"]
    hybrid = file.map
    saved(-1)
    for node in range(len(hybrid.graph), nodes):
        hybrid.add_node(corner="concave", turn=float(rng.normal()), local_map=local_map(rng))
        if node:
            hybrid.add_arc(node - 1, node, "right", float(rng.uniform(0.2, 0.6)), 1e-4)
        file.append(
            hybrid, node, state={"rng": rng.bit_generator.state}, truth={"pose": [0.5, float(node), 0.0]}
        )
        saved(node)
    if not hybrid.graph.has_edge(nodes - 1, 0, "right"):
        arc = hybrid.add_arc(nodes - 1, 0, "right", float(rng.uniform(0.2, 0.6)), 1e-4)
        hybrid.meta = MapMeta(world="made-up", seed=seed, loop_closed=True)
        file.update(hybrid, arcs=[(arc.start, arc.end, "right"), (arc.end, arc.start, "left")])
    file.seal()


def content_digest(path: Path) -> str:
    """A hash of everything a map file holds, read through the public functions. Raises: MapError."""
    hybrid = HybridMap.load(path)
    whole: list[Any] = [hybrid.meta.to_json()]
    for node in hybrid.nodes():
        data = dict(hybrid.graph.nodes[node])
        local: LocalMap | None = data.pop("local_map")
        packed = None if local is None else pack_local_map(local.content)
        whole.append([node, data, None if packed is None else [packed[0], packed[1].hex()]])
    for arc in hybrid.arcs():
        whole.append(repr(arc))
    truth = read_truth(path)
    whole.append([sorted(truth.nodes.items()), truth.run, repr(read_state(path))])
    return hashlib.blake2b(json.dumps(whole, sort_keys=True).encode()).hexdigest()
