"""What the page shows of a hybrid map: nodes with their local maps, and arcs."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ...maps import HybridMap, LocalMap
from ...world.robot import Pose
from .packing import Series
from .ticks import gray

PLACE_STEP = 0.0005


def map_content(
    hybrid: HybridMap, poses: Mapping[int, Pose], only: Collection[int] | None = None
) -> dict[str, Any]:
    """Nodes and arcs of a map for `pack`. poses: where the nodes stand in the page's frame (m, rad).

    only: the nodes that are wanted; None wants all.
    """
    wanted = [node for node in hybrid.nodes() if only is None or node in only]
    return {
        "nodes": [node_content(hybrid, node, poses.get(node)) for node in wanted],
        "arcs": [
            [arc.start, arc.end, arc.kind, arc.distance, arc.variance, arc.traversals, arc.blocked]
            for arc in hybrid.arcs()
        ],
    }


def node_content(hybrid: HybridMap, node: int, pose: Pose | None) -> dict[str, Any]:
    """One node; without a pose it is listed and not drawn."""
    data = hybrid.graph.nodes[node]
    local_map: LocalMap | None = data["local_map"]
    return {
        "node": node,
        "name": str(data["name"]),
        "corner": str(data["corner"]),
        "turn": float(data["turn"]),
        "entry": float(data["entry_heading"]),
        "pose": None if pose is None else [pose.x, pose.y, pose.heading],
        "local": None if local_map is None else local_content(local_map),
    }


def local_content(local_map: LocalMap) -> dict[str, Any]:
    """Both SOMs of a local map, and the views at its node."""
    metric, views = local_map.metric, local_map.perceptual
    edges, blocked = local_map.edges.tolist(), local_map.blocked
    content: dict[str, Any] = {
        "x": Series(metric.weights[:, 0], PLACE_STEP),
        "y": Series(metric.weights[:, 1], PLACE_STEP),
        "hits": np.minimum(local_map.hits, 65535).astype(np.uint16),
        "edges": np.array(edges, dtype=np.uint16).ravel(),
        "blocked": [index for index, (a, b) in enumerate(edges) if (a, b) in blocked],
        "metric": [metric.lattice.rows, metric.lattice.cols],
        "panorama": None if local_map.entry_panorama is None else gray(local_map.entry_panorama),
    }
    if views is not None and local_map.view_positions is not None:
        seen = np.isfinite(local_map.view_positions).all(axis=1)
        content |= {
            "views": gray(views.weights),
            "perceptual": [views.lattice.rows, views.lattice.cols, views.lattice.topology],
            "seen": seen.astype(np.uint8),
            "viewX": Series(local_map.view_positions[:, 0], PLACE_STEP),
            "viewY": Series(local_map.view_positions[:, 1], PLACE_STEP),
        }
    return content
