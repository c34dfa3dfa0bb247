"""The truth section of a map file: where nodes truly are and what was truly driven, to score and to draw.

Only scripts/ read and write it; the agent and its HybridMap never do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...maps.storage.map_file import read_truth
from ...world.robot import Pose

TRACK_STEP = 0.01
"""Meters between two points of a track that is kept."""


@dataclass(frozen=True, slots=True)
class TrueRun:
    """nodes: true pose of each node at its commit, heading = entry heading. track: (n, 2) m. World frame."""

    nodes: Mapping[int, Pose]
    track: NDArray[np.float64]


def node_truth(pose: Pose, track: Iterable[tuple[float, float]]) -> dict[str, Any]:
    """What is kept with one node, as JSON: its true pose (m, rad) and the track since the node before (m).

    Rounded to 0.1 mm and 1e-6 rad: enough to draw and to score, and short.
    """
    return {
        "pose": [round(pose.x, 6), round(pose.y, 6), round(pose.heading, 6)],
        "track": _short(track),
    }


def run_truth(track: Iterable[tuple[float, float]]) -> dict[str, Any]:
    """What is kept about a run as a whole, as JSON: the track (m) after its last node."""
    return {"track": _short(track)}


def read_map_truth(path: Path) -> TrueRun | None:
    """The truth that a map file has, or None if it has none (a map by a real robot, an imported one).

    Raises: MapError if the file cannot be read.
    """
    truth = read_truth(path)
    nodes = {node: Pose(*map(float, record["pose"])) for node, record in truth.nodes.items()}
    if not nodes:
        return None
    records = [*(truth.nodes[node] for node in sorted(nodes)), truth.run]
    pieces = [np.array(record.get("track", []), dtype=float).reshape(-1, 2) for record in records]
    return TrueRun(nodes, np.concatenate(pieces))


def _short(track: Iterable[tuple[float, float]]) -> list[list[float]]:
    return [[round(float(x), 4), round(float(y), 4)] for x, y in track]
