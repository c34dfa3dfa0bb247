"""Maps one world several times, from different starts and along both walls, and compares all pairs of maps.

`diff` and `merge` see the maps alone; what they say is then judged by where the nodes truly were.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from tolman.maps import HybridMap, NoMatchError, compare, merge
from tolman.maps.boundary.walk import boundaries
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world
from tolman.scripts.session.truth import read_map_truth
from tolman.world.arenas.catalog import built_in_world
from tolman.world.geometry import Plan
from tolman.world.robot import Pose
from tolman.world.starts import find_start

WORLD, OTHER_WORLD = "env2", "env1"
SAME_PLACE = 0.12
"""Meters between the true places of one corner's node in two maps, at most: both ways round it differ."""

LEAST_SHARE = 95
"""Per cent of the nodes that two maps share which must be matched."""


@dataclass(frozen=True, slots=True)
class Made:
    """A map and the true pose of each of its nodes."""

    map: HybridMap
    truth: Mapping[int, Pose]


def pairs(
    folder: Path, count: int = 20, seed: int = 0, local_maps: int = 2, engine: str = "dart"
) -> Counter[str]:
    """Compares and merges `count` pairs of maps of one world, and refuses to with a map of another.

    local_maps: how many of the maps are made with local maps. seed: of the first map; further ones count up.
    """
    needed = next(size for size in range(2, count + 2) if size * (size - 1) // 2 >= count)
    made = [_mapped(folder, WORLD, seed + index, index < local_maps, engine) for index in range(needed)]
    result: Counter[str] = Counter({"maps": needed})
    for one, other in list(combinations(made, 2))[:count]:
        _judge_pair(one, other, result)
    stranger = _mapped(folder, OTHER_WORLD, seed, False, engine)
    for one in made:
        result["pairs of different worlds"] += 1
        try:
            compare(one.map, stranger.map)
        except NoMatchError:
            result["of those refused"] += 1
    result["matched across worlds"] = result["pairs of different worlds"] - result["of those refused"]
    share = 100 * result["nodes matched rightly"] / max(1, result["nodes that both maps have"])
    result["per cent of nodes matched"] = int(share)
    result["too few nodes matched"] = int(share < LEAST_SHARE)
    return result


def _mapped(folder: Path, world: str, seed: int, local_maps: bool, engine: str) -> Made:
    """A map from a start of its own, along the right-hand wall for even seeds, else the left-hand one."""
    path = folder / f"{world}-{seed}.tolman"
    spec = built_in_world(world)
    near = np.random.default_rng(np.random.SeedSequence([seed, 5])).uniform(0.0, 1.5, 2)
    start = find_start(Plan(spec.shapes), (float(near[0]), float(near[1])))
    assert start is not None
    side = "left" if seed % 2 else "right"
    if side == "left":
        start = Pose(start.x, start.y, start.heading + np.pi)
    request = MapRequest(
        world=world, output=path, side=side, seed=seed, start=start, global_only=not local_maps, engine=engine
    )
    report = map_world(request)
    if not report.loop_closed:
        print(f"{world}, seed {seed}: {report.reason}; the map is compared all the same", file=sys.stderr)
    truth = read_map_truth(path)
    assert truth is not None
    return Made(HybridMap.load(path), truth.nodes)


def _judge_pair(one: Made, other: Made, result: Counter[str]) -> None:
    result["pairs"] += 1
    shared = _shared(one, other)
    result["nodes that both maps have"] += len(shared)
    try:
        found = compare(one.map, other.map)
    except NoMatchError as error:
        print(f"refused: {error}", file=sys.stderr)
        result["pairs refused"] += 1
        return
    for a, b in found.matched.items():
        right = shared.get(a) == b or one.truth[a].distance_to(other.truth[b]) <= SAME_PLACE
        result["nodes matched rightly" if right else "nodes matched wrongly"] += 1
    merged = merge(one.map, other.map, found)
    wall = boundaries(merged)
    whole = len(wall) == 1 and wall[0].closed and len(wall[0]) == len(one.map.graph) + len(found.only_other)
    result["merged to one closed boundary"] += whole
    result["merged to something else"] += not whole


def _shared(one: Made, other: Made) -> dict[int, int]:
    """The nodes of both maps that are the same corner: each the other's nearest, and near."""
    here = np.array([[pose.x, pose.y] for pose in one.truth.values()])
    there = np.array([[pose.x, pose.y] for pose in other.truth.values()])
    apart = np.linalg.norm(here[:, None] - there, axis=2)
    names, others = list(one.truth), list(other.truth)
    return {
        names[i]: others[j]
        for i, j in enumerate(apart.argmin(axis=1).tolist())
        if apart[:, j].argmin() == i and apart[i, j] <= SAME_PLACE
    }
