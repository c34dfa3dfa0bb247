"""From a map file to what is drawn of it: placed by the truth if the file has it, else by the map alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...maps import HybridMap, LocalMap
from ...maps.boundary.layout import layout
from ...world.arenas.catalog import find_world
from ...world.errors import WorldError
from ...world.robot import Pose
from ...world.spec import Shape
from ..session.truth import read_map_truth
from .plot import save_drawing
from .style import ArcLine, Drawing, Lattice


def alone(hybrid: HybridMap) -> dict[int, Pose]:
    """Poses of the nodes as the map alone has them: its arcs laid end to end. Map frame."""
    headings = {node: float(hybrid.graph.nodes[node]["entry_heading"]) for node in hybrid.nodes()}
    return {node: Pose(x, y, headings[node]) for node, (x, y) in layout(hybrid).items()}


def lattice_of(local_map: LocalMap) -> Lattice:
    """What is drawn of a local map."""
    edges = [(int(a), int(b)) for a, b in local_map.edges]
    weights = np.asarray(local_map.metric.weights, dtype=float)
    return Lattice(weights[:, :2], edges, np.asarray(local_map.hits) > 0, local_map.blocked)


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
    poses = {node: truth.nodes[node] for node in hybrid.nodes()} if truth and known else alone(hybrid)
    lattices = {}
    for node in hybrid.nodes():
        local_map = hybrid.local_map(node)
        if local_map is not None:
            lattices[node] = lattice_of(local_map)
    arcs = [
        ArcLine(arc.start, arc.end, arc.distance, arc.kind == "foray", arc.blocked) for arc in hybrid.arcs()
    ]
    track: NDArray[np.float64] = truth.track if truth and known else np.empty((0, 2))
    return Drawing(
        title=title(hybrid, placed_by_truth=known),
        nodes=poses,
        arcs=arcs,
        lattices=lattices,
        shapes=walls_of(hybrid, world, scale) if known else (),
        track=track,
        corners={node: str(hybrid.graph.nodes[node]["corner"]) for node in hybrid.nodes()},
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
