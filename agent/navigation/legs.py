"""Arcs of a map as legs to drive, one after the other (section 3.5)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...maps.errors import MapError
from ..boundary.trace import BLUNT
from ..goals import START_AT, Crossing, FollowFrom, Leg

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap

CROSSING = "crossing"
"""Note of a crossing's arc: how it is driven, the fields of `goals.Crossing`."""


def legs_along(hybrid_map: HybridMap, arcs: Iterable[Arc], arrival: str) -> tuple[Leg, ...]:
    """These arcs as legs to drive, one after the other.

    arrival: the side of the wall by which the robot came to where they begin, which says how it stands there:
    in the entry heading if that is the side the map was made by, else as it arrives from the other direction.
    Raises: MapError if the map does not say how one of them is driven.
    """
    legs: list[Leg] = []
    side: str | None = arrival
    for arc in arcs:
        if arc.kind == "foray":
            legs.append(_crossing_leg(hybrid_map, arc))
        else:
            legs.append(_leg(hybrid_map, arc, side, first=not legs or legs[-1].crossing is not None))
        side = arc.side
    return tuple(legs)


def _crossing_leg(hybrid_map: HybridMap, arc: Arc) -> Leg:
    """Raises: MapError if the map does not say how the crossing is driven."""
    try:
        crossing = Crossing(**arc.notes[CROSSING])
    except (KeyError, TypeError):
        raise MapError(
            f"arc {arc.start} -> {arc.end} (foray): its notes lack {CROSSING!r}, how it is driven"
        ) from None
    data = hybrid_map.graph.nodes[arc.start]
    start = START_AT[data["corner"]]
    corner = hybrid_map.graph.nodes[arc.end]["corner"]
    return Leg(arc.start, arc.end, arc.side, arc.distance, corner, 0.0, start, data["turn"] or None, crossing)


def _leg(hybrid_map: HybridMap, arc: Arc, side: str | None, first: bool) -> Leg:
    nodes = hybrid_map.graph.nodes
    begin, corner = nodes[arc.start]["corner"], nodes[arc.end]["corner"]
    turn, start, bend = 0.0, None, None
    if arc.side != side:
        turn, start = math.pi, FollowFrom.GAP if begin == "convex" else FollowFrom.WALL
    elif first:
        start, bend = START_AT[begin], nodes[arc.start]["turn"] or None
    blunt = corner != "none" and 0.0 < abs(nodes[arc.end]["turn"]) < BLUNT
    return Leg(arc.start, arc.end, arc.side, arc.distance, corner, turn, start, bend, blunt=blunt)
