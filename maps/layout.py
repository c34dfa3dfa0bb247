"""Where the nodes lie, for drawing and export: dead reckoning along the arcs, closing errors spread out."""

from __future__ import annotations

import math

from .hybrid_map import HybridMap

Point = tuple[float, float]


def layout(hybrid: HybridMap) -> dict[int, Point]:
    """x, y (m) of every node in the map frame, the lowest node of each part at (0, 0) and parts side by side.

    An arc of the side mapped with leaves a node along its entry heading plus its turn, straight on. What is
    missing when a loop comes back to its start is spread over its arcs by length. For pictures: navigation
    never uses it.
    """
    side = "left" if hybrid.meta.side == "left" else "right"
    places: dict[int, Point] = {}
    offset = 0.0
    for start in _starts(hybrid, side):
        if start in places:
            continue
        chain, part = [start], {start: (0.0, 0.0)}
        position, back = (0.0, 0.0), None
        while (arc := hybrid.next_arc(chain[-1], side)) is not None:
            position = _ahead(hybrid, chain[-1], position, arc.distance)
            if arc.end in part or arc.end in places:
                back = arc.end
                break
            part[arc.end] = position
            chain.append(arc.end)
        if back == start:
            _spread(hybrid, chain, part, position, side)
        shift = offset - min(x for x, _ in part.values()) if places else 0.0
        places.update({node: (x + shift, y) for node, (x, y) in part.items()})
        offset = max(x for x, _ in places.values()) + 0.5
    return places


def _starts(hybrid: HybridMap, side: str) -> list[int]:
    reached = {arc.end for arc in hybrid.arcs() if arc.kind == side}
    return [node for node in hybrid.nodes() if node not in reached] + hybrid.nodes()


def _ahead(hybrid: HybridMap, node: int, position: Point, distance: float) -> Point:
    data = hybrid.graph.nodes[node]
    heading = data["entry_heading"] + data["turn"]
    return position[0] + distance * math.cos(heading), position[1] + distance * math.sin(heading)


def _spread(hybrid: HybridMap, chain: list[int], part: dict[int, Point], end: Point, side: str) -> None:
    """Shifts the nodes of a closed chain so that it ends where it began."""
    lengths = [arc.distance for node in chain if (arc := hybrid.next_arc(node, side)) is not None]
    total, driven = sum(lengths) or 1.0, 0.0
    for node, length in zip(chain, lengths, strict=False):
        x, y = part[node]
        part[node] = (x - end[0] * driven / total, y - end[1] * driven / total)
        driven += length
