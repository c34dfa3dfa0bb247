"""Where the nodes lie, for drawing and export: dead reckoning along the arcs, closing errors spread out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..fields import MAX_METERS
from .walk import Walk, close_polygon, onward, walk

if TYPE_CHECKING:
    from ..hybrid_map import HybridMap

Point = tuple[float, float]

PLACE = "place_m"
"""Note of a node of a boundary that a foray found: its x, y (m) in the map frame."""


def layout(hybrid: HybridMap) -> dict[int, Point]:
    """x, y (m) of every node in the map frame: the first part begins at (0, 0), others lie where a note says.

    Parts without such a note (`PLACE`) are set side by side. An arc of the side mapped with leaves a node
    along its entry heading plus its turn, straight on. What is missing when a loop comes back to its start is
    spread over its arcs by length. For pictures: navigation never uses it.
    """
    side = "left" if hybrid.meta.side == "left" else "right"
    follow = onward(hybrid, side)
    places: dict[int, Point] = {}
    offset = 0.0
    for start in _starts(hybrid, side):
        if start in places:
            continue
        part = _laid_out(hybrid, walk(follow, start, places))
        known = _known_place(hybrid, part)
        aside = offset - min(x for x, _ in part.values()) if places else 0.0
        dx, dy = (aside, 0.0) if known is None else known
        places.update({node: (x + dx, y + dy) for node, (x, y) in part.items()})
        offset = max(x for x, _ in places.values()) + 0.5
    return places


def _laid_out(hybrid: HybridMap, way: Walk) -> dict[int, Point]:
    """x, y (m) of the nodes of a walk that begins at (0, 0); a closed one ends where it began."""
    points: list[Point] = [(0.0, 0.0)]
    for node, length in zip(way.nodes, way.lengths, strict=False):
        points.append(_ahead(hybrid, node, points[-1], length))
    if way.closed:
        points = [*close_polygon(points[:-1], way.lengths, points[-1], way.length or 1.0)]
    return dict(zip(way.nodes, points, strict=False))


def place_in(notes: Mapping[str, Any]) -> Point | None:
    """The place (m) in a node's notes, None without one; as notes are free, anything may be there."""
    match notes.get(PLACE):
        case [int() | float() as x, int() | float() as y] if abs(x) <= MAX_METERS and abs(y) <= MAX_METERS:
            return float(x), float(y)
    return None


def _known_place(hybrid: HybridMap, part: dict[int, Point]) -> Point | None:
    """By how much a part is to be moved so that a node with a note lies where that says; None without one."""
    for node, (x, y) in part.items():
        place = place_in(hybrid.graph.nodes[node]["notes"])
        if place is not None:
            return place[0] - x, place[1] - y
    return None


def _starts(hybrid: HybridMap, side: str) -> list[int]:
    reached = {arc.end for arc in hybrid.arcs() if arc.kind == side}
    return [node for node in hybrid.nodes() if node not in reached] + hybrid.nodes()


def _ahead(hybrid: HybridMap, node: int, position: Point, distance: float) -> Point:
    data = hybrid.graph.nodes[node]
    heading = data["entry_heading"] + data["turn"]
    return position[0] + distance * math.cos(heading), position[1] + distance * math.sin(heading)
