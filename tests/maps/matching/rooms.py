"""Made-up rooms: boundaries with corners and lengths, and maps of them from any start and side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta


@dataclass(frozen=True)
class Room:
    """Corners in right-hand order, the walls' lengths (m) after them, and a view at each."""

    corners: tuple[str, ...]
    lengths: tuple[float, ...]
    seed: int


def random_room(seed: int, size: int = 24) -> Room:
    """A room whose turns add up to one round: four more concave corners than convex."""
    rng = np.random.default_rng(seed)
    convex = (size - 4) // 2
    corners = ["convex"] * convex + ["concave"] * (size - convex)
    rng.shuffle(corners)
    return Room(tuple(corners), tuple(rng.uniform(0.1, 0.9, size).tolist()), seed)


def map_of(
    room: Room,
    start: int = 0,
    side: str = "right",
    noise: float = 0.01,
    seed: int = 0,
    missing: tuple[int, ...] = (),
    views: bool = False,
    closed: bool = True,
) -> tuple[HybridMap, dict[int, int]]:
    """A map of the room and the true corner of each of its nodes."""
    rng = np.random.default_rng([seed, room.seed])
    size = len(room.corners)
    order = [(start + index) % size for index in range(size)]
    if side == "left":
        order.reverse()
    order = [corner for corner in order if corner not in missing]
    hybrid, true = HybridMap(MapMeta(world=f"room{room.seed}", side=side, loop_closed=closed)), {}
    heading = float(rng.uniform(-math.pi, math.pi))
    quarter = 0
    for corner in order:
        turn = (1 if room.corners[corner] == "concave" else -1) * (1 if side == "right" else -1)
        local = _view(room, corner, quarter, side) if views else None
        node = hybrid.add_node(
            corner=room.corners[corner],
            turn=turn * math.pi / 2 + float(rng.normal(0.0, 0.03)),
            entry_heading=math.remainder(heading + quarter * math.pi / 2, math.tau),
            local_map=local,
        )
        true[node] = corner
        quarter += turn
    ends = [*range(1, len(order)), 0] if closed else range(1, len(order))
    for node, end in enumerate(ends):
        length = _length(room, true[node], true[end], side)
        hybrid.add_arc(node, end, side, max(0.01, length + float(rng.normal(0.0, noise))), noise**2)
    return hybrid, true


def _length(room: Room, start: int, end: int, side: str) -> float:
    if side == "left":
        start, end = end, start
    total = 0.0
    while True:
        total += room.lengths[start]
        start = (start + 1) % len(room.corners)
        if start == end:
            return total


def _view(room: Room, corner: int, quarter: int, side: str) -> LocalMap:
    """A corner's view, the same from all maps but for the direction in which it is entered."""
    world = np.random.default_rng([99, room.seed, corner]).uniform(0.0, 1.0, (4, 16, 16))
    absolute = sum(1 if kind == "concave" else -1 for kind in room.corners[:corner])
    if side == "left":
        absolute += (1 if room.corners[corner] == "concave" else -1) + 2
    return LocalMap.build(
        [[0.0, 0.0], [0.02, 0.0], [0.0, 0.02]], entry_panorama=np.roll(world, -absolute, axis=0)
    )
