"""From a map file to what is drawn of it: placed by the truth if the file has it, else by the map alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..maps import HybridMap
from ..maps.local_map import LocalMap
from ..world.arenas import find_world
from ..world.base import WorldError
from ..world.robot import Pose
from ..world.spec import Shape
from .plot import ArcLine, Drawing, Lattice, save_drawing
from .truth import read_map_truth


def chain(hybrid: HybridMap) -> tuple[list[int], list[float]]:
    """The nodes in the order of mapping, and the distance (m) of the arc that leaves each of them.

    The last distance is there only if the loop is closed: then there are as many as nodes.
    """
    nodes = hybrid.nodes()[:1]
    distances: list[float] = []
    while nodes and (arc := hybrid.next_arc(nodes[-1], hybrid.meta.side)) is not None:
        distances.append(arc.distance)
        if arc.end in nodes:
            break
        nodes.append(arc.end)
    return nodes, distances


def layout(hybrid: HybridMap) -> dict[int, Pose]:
    """Poses of the nodes as the map alone has them: arcs laid end to end along the nodes' entry headings.

    The gap that remains when the loop closes is spread evenly over its arcs. Nodes that are not on the loop
    are placed from a neighbor that is. Map frame, the first node at the origin.
    """
    nodes, distances = chain(hybrid)
    headings = {node: float(hybrid.graph.nodes[node]["entry_heading"]) for node in hybrid.nodes()}
    steps = [
        (length * math.cos(headings[node]), length * math.sin(headings[node]))
        for node, length in zip([*nodes[1:], *nodes[:1]], distances, strict=False)
    ]
    ends = np.vstack([[0.0, 0.0], np.cumsum(np.array(steps).reshape(-1, 2), axis=0)])
    if nodes and len(distances) == len(nodes):
        ends -= np.linspace(0.0, 1.0, len(ends))[:, None] * ends[-1]
    poses = {
        node: Pose(float(x), float(y), headings[node]) for node, (x, y) in zip(nodes, ends, strict=False)
    }
    return _with_branches(hybrid, poses, headings)


def _with_branches(
    hybrid: HybridMap, poses: dict[int, Pose], headings: Mapping[int, float]
) -> dict[int, Pose]:
    """Adds the nodes that no pose is known of yet, one arc's length from a neighbor."""
    for _ in range(len(hybrid.graph)):
        for arc in hybrid.arcs():
            if arc.start in poses and arc.end not in poses:
                there = Pose(poses[arc.start].x, poses[arc.start].y, headings[arc.end]).compose(
                    arc.distance, 0
                )
                poses[arc.end] = there
    for node in hybrid.nodes():
        poses.setdefault(node, Pose(0.0, 0.0, headings[node]))
    return poses


def lattice_of(local_map: LocalMap) -> Lattice:
    """What is drawn of a local map."""
    edges = [(int(a), int(b)) for a, b in local_map.edges]
    weights = np.asarray(local_map.metric.weights, dtype=float)
    return Lattice(weights[:, :2], edges, np.asarray(local_map.hits) > 0)


def walls_of(hybrid: HybridMap, world: str | None, scale: float = 1.0) -> tuple[Shape, ...]:
    """The walls of the world the map was made in, or none if it cannot be found.

    world: name or file to draw instead of the one the map names; scale: of the file's lengths.

    Raises: WorldError if that cannot be read.
    """
    if world is not None:
        return find_world(world, scale).shapes
    try:
        spec = find_world(hybrid.meta.world)
    except WorldError:
        return ()
    return spec.shapes if spec.digest == hybrid.meta.world_digest else ()


def drawing_of(path: Path, world: str | None = None, scale: float = 1.0) -> Drawing:
    """What is drawn of a map file.

    With a truth section everything stands where it truly is, walls and driven path included; without, the map
    is laid out by its own arcs.

    Raises: MapError if the file cannot be read, WorldError for an unknown `world`.
    """
    hybrid = HybridMap.load(path)
    truth = read_map_truth(path)
    known = truth is not None and set(hybrid.graph) <= truth.nodes.keys()
    poses = {node: truth.nodes[node] for node in hybrid.nodes()} if truth and known else layout(hybrid)
    lattices = {}
    for node in hybrid.nodes():
        local_map = hybrid.local_map(node)
        if local_map is not None:
            lattices[node] = lattice_of(local_map)
    arcs = [ArcLine(arc.start, arc.end, arc.distance) for arc in hybrid.arcs()]
    track: NDArray[np.float64] = truth.track if truth and known else np.empty((0, 2))
    return Drawing(
        title=title(hybrid, placed_by_truth=known),
        nodes=poses,
        arcs=arcs,
        lattices=lattices,
        shapes=walls_of(hybrid, world, scale) if known else (),
        track=track,
    )


def title(hybrid: HybridMap, *, placed_by_truth: bool) -> str:
    """What the picture shows, in two lines."""
    meta = hybrid.meta
    closed = "loop closed" if meta.loop_closed else "loop not closed"
    where = "drawn at the true places of the nodes" if placed_by_truth else "laid out by the map's own arcs"
    return (
        f"{meta.world or 'a map'}: {len(hybrid.graph)} nodes, {closed}; {meta.side}-hand wall, "
        f"noise {meta.noise}, seed {meta.seed}, profile {meta.profile}\n{where}"
    )


def plot_map(path: Path, picture: Path, world: str | None = None, scale: float = 1.0) -> None:
    """Draws a map file to a picture. Raises: MapError, WorldError, OSError."""
    save_drawing(drawing_of(path, world, scale), picture)
