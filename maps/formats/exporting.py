"""Maps for other programs: GraphML, JSON, a Nav2-style GeoJSON route graph, a ROS map_server image."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from ...files.writing import check_target, write_bytes
from ...world.robot import EPUCK
from ..boundary.layout import layout
from ..errors import MapError
from ..fields import ARC, NODE, Record, Scalar
from ..storage.writer import file_errors
from .json_map import to_json

if TYPE_CHECKING:
    from ..hybrid_map import HybridMap

RESOLUTION = 0.01
"""Meters a cell of the ROS map."""

FREE, UNKNOWN = 254, 205
MAX_CELLS = 64 << 20


def export(hybrid: HybridMap, form: str, path: str | os.PathLike[str], force: bool = False) -> list[Path]:
    """Writes a map as `graphml`, `json`, `geojson` or `ros` and returns the files written.

    ros writes a YAML file and, beside it, the PGM it names. Raises: MapError for an unknown form or a map
    that cannot be drawn, MapFileExistsError without force, MapFileError.
    """
    if form not in FORMS:
        raise MapError(f"unknown export format {form!r}; known: {', '.join(sorted(FORMS))}")
    files = FORMS[form](hybrid, Path(path))
    for target in files:
        with file_errors(target, "write"):
            check_target(target, replace=force)
    for target, data in files.items():
        with file_errors(target, "write"):
            write_bytes(target, data, replace=force)
    return list(files)


def _json(hybrid: HybridMap, path: Path) -> dict[Path, bytes]:
    return {path: json.dumps(to_json(hybrid), sort_keys=True, allow_nan=False).encode()}


def _graphml(hybrid: HybridMap, path: Path) -> dict[Path, bytes]:
    """Scalars only, as GraphML wants it: notes as JSON text, positions from `layout`."""
    graph: nx.MultiDiGraph[int] = nx.MultiDiGraph(world=hybrid.meta.world, side=hybrid.meta.side)
    places = layout(hybrid)
    for node in hybrid.nodes():
        data = hybrid.graph.nodes[node]
        x, y = places[node]
        graph.add_node(node, **_scalars(NODE, data), x=x, y=y, has_local_map=data["local_map"] is not None)
    for arc in hybrid.arcs():
        graph.add_edge(arc.start, arc.end, key=arc.kind, **_scalars(ARC, arc.values()))
    out = BytesIO()
    nx.write_graphml_xml(graph, out)
    return {path: out.getvalue()}


def _scalars(record: Record, values: Mapping[str, Any]) -> dict[str, Scalar]:
    """All fields; None, which GraphML does not know, is left out."""
    told = {name: each.scalar(values[name]) for name, each in record.by_name.items()}
    return {name: value for name, value in told.items() if value is not None}


def _for_routes(record: Record, values: Mapping[str, Any]) -> dict[str, Any]:
    return {each.name: values[each.name] for each in (*record.keys, *record.fields) if each.route}


def _geojson(hybrid: HybridMap, path: Path) -> dict[Path, bytes]:
    """Nav2's route server graph: nodes as points, arcs as lines with cost and metadata, unique ids."""
    places = layout(hybrid)
    features: list[dict[str, Any]] = []
    for node in hybrid.nodes():
        data = hybrid.graph.nodes[node]
        about = {"id": node, "frame": "map", "metadata": _for_routes(NODE, data)}
        features.append(_feature(about, "Point", list(places[node])))
    first = max(hybrid.nodes(), default=-1) + 1
    for number, arc in enumerate((arc for arc in hybrid.arcs() if not arc.blocked), first):
        about = {
            "id": number,
            "startid": arc.start,
            "endid": arc.end,
            "cost": arc.distance,
            "overridable": True,
            "metadata": _for_routes(ARC, {"kind": arc.kind, **arc.values()}),
        }
        line = [[list(places[arc.start]), list(places[arc.end])]]
        features.append(_feature(about, "MultiLineString", line))
    whole = {"type": "FeatureCollection", "name": hybrid.meta.world or "tolman", "features": features}
    return {path: json.dumps(whole, indent=1, allow_nan=False).encode()}


def _feature(about: dict[str, Any], kind: str, coordinates: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": about, "geometry": {"type": kind, "coordinates": coordinates}}


def _ros(hybrid: HybridMap, path: Path) -> dict[Path, bytes]:
    """What the metric SOMs know to be free, widened by the robot's body; the rest is unknown."""
    segments = free_segments(hybrid)
    if not segments:
        raise MapError("no node has a local map: there is no free space to draw for ROS")
    margin = EPUCK.body_radius + 2 * RESOLUTION
    ends = np.array(segments).reshape(-1, 2)
    low = np.floor((ends.min(axis=0) - margin) / RESOLUTION) * RESOLUTION
    width, height = (int(n) for n in np.ceil((ends.max(axis=0) + margin - low) / RESOLUTION))
    if width * height > MAX_CELLS:
        raise MapError(f"a ROS map of {width} x {height} cells: at most {MAX_CELLS}")
    grid = np.full((height, width), UNKNOWN, dtype=np.uint8)
    for start, end in segments:
        _widen(grid, np.array(start) - low, np.array(end) - low)
    image = path.with_suffix(".pgm")
    sheet = path.with_suffix(".yaml") if path.suffix in ("", ".pgm") else path
    text = (
        f"image: {json.dumps(image.name)}\nmode: trinary\nresolution: {RESOLUTION}\n"
        f"origin: [{low[0]:.6f}, {low[1]:.6f}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    header = f"P5\n{width} {height}\n255\n".encode()
    return {image: header + np.flipud(grid).tobytes(), sheet: text.encode()}


Segment = tuple[tuple[float, float], tuple[float, float]]


def free_segments(hybrid: HybridMap) -> list[Segment]:
    """The metric SOMs' free space, map frame, m: hit units as points, kept edges not blocked."""
    found: list[Segment] = []
    places = layout(hybrid)
    for node in hybrid.nodes():
        local = hybrid.local_map(node)
        if local is None:
            continue
        heading, (x, y) = local.entry_heading, places[node]
        turn = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
        spots = [(float(a), float(b)) for a, b in local.metric.weights @ turn.T + (x, y)]
        found += [(spots[unit], spots[unit]) for unit in np.flatnonzero(local.hits > 0).tolist()]
        blocked = local.blocked
        found += [(spots[i], spots[j]) for i, j in local.edges.tolist() if (i, j) not in blocked]
    return found


def _widen(grid: NDArray[np.uint8], start: NDArray[np.float64], end: NDArray[np.float64]) -> None:
    """Marks as free all cells whose center is within the robot's radius of a segment (m from the corner)."""
    radius = EPUCK.body_radius
    first = np.maximum((np.minimum(start, end) - radius) / RESOLUTION, 0).astype(int)
    last = ((np.maximum(start, end) + radius) / RESOLUTION).astype(int) + 1
    part = grid[first[1] : last[1], first[0] : last[0]]
    rows, cols = np.mgrid[0 : part.shape[0], 0 : part.shape[1]]
    centers = np.stack([cols + first[0] + 0.5, rows + first[1] + 0.5], axis=-1) * RESOLUTION - start
    along = end - start
    share = np.clip(centers @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    away = np.linalg.norm(centers - share[..., None] * along, axis=-1)
    part[away <= radius] = FREE


FORMS: dict[str, Callable[[HybridMap, Path], dict[Path, bytes]]] = {
    "graphml": _graphml,
    "json": _json,
    "geojson": _geojson,
    "ros": _ros,
}
