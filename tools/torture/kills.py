"""Kills a process that maps, again and again, and looks for what it had reported as saved. POSIX only."""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
from tolman.maps import HybridMap, MapError
from tolman.maps.storage.packing import pack_local_map

from .children import in_child
from .maps import map_made_up_world


def kills(count: int, seed: int, folder: Path, resumed: int = 50, nodes: int = 4) -> Counter[str]:
    """Kills a mapping process `count` times; resumes the first `resumed` unfinished ones to the end."""
    rng = np.random.default_rng(seed)
    whole = folder / "whole.tolman"
    started = time.monotonic()
    map_made_up_world(whole, nodes, 0)
    usual = time.monotonic() - started
    expected, wanted = whole.read_bytes(), HybridMap.load(whole)
    result: Counter[str] = Counter()
    for index in range(count):
        path = folder / f"killed-{index}.tolman"
        reported = _map_and_kill(path, nodes, float(rng.uniform(0.0, 1.3 * usual)))
        _judge(path, reported, wanted, result)
        if result["resumed"] < resumed and reported >= 0 and path.exists():
            map_made_up_world(path, nodes, 0, resume=True)
            result["resumed"] += 1
            result["resumed to other bytes"] += path.read_bytes() != expected
        for leftover in folder.glob(f"killed-{index}.tolman*"):
            leftover.unlink()
    return result


def _map_and_kill(path: Path, nodes: int, after: float) -> int:
    """Runs the mapping in a child and kills it after some seconds: the last node it reported, -2 for none."""
    told, _ = in_child(
        lambda tell: map_made_up_world(path, nodes, 0, lambda node: tell(bytes([node + 1]))), after
    )
    return told[-1] - 1 if told else -2


def _judge(path: Path, reported: int, wanted: HybridMap, result: Counter[str]) -> None:
    result["killed"] += 1
    if reported < -1:
        result["killed before the file was reported"] += 1
        return
    try:
        found = HybridMap.load(path)
    except MapError as error:
        print(f"does not open: {error}", file=sys.stderr)
        result["does not open"] += 1
        return
    for node in range(reported + 1):
        same = node in found.graph and _same_node(found, wanted, node)
        result["nodes lost"] += not same
    result["nodes reported"] += reported + 1


def _same_node(found: HybridMap, wanted: HybridMap, node: int) -> bool:
    one, other = found.local_map(node), wanted.local_map(node)
    if one is None or other is None:
        return False
    same = pack_local_map(one.content) == pack_local_map(other.content)
    return same and found.graph.nodes[node]["turn"] == wanted.graph.nodes[node]["turn"]
