"""Joins two maps of the same world into one that knows what either knew."""

from __future__ import annotations

from dataclasses import replace

from ..boundary.layout import PLACE, place_in
from ..fields import Arc
from ..hybrid_map import HybridMap
from ..local.local_map import LocalMap
from .comparing import Comparison, compare
from .frames import Frames

SLACK = 0.05
"""Meters by which two ways along the same wall may differ, besides a fifth of their length."""

LEAST_REST = 0.01
"""Meters between two corners, at least, where the two maps' lengths say that they fall together."""


def merge(one: HybridMap, other: HybridMap, comparison: Comparison | None = None) -> HybridMap:
    """A new map in the one's frame and numbering: its nodes, the other's further nodes, what both measured.

    An arc both have gets the mean of their distances, weighted by traversals. Where one map has a corner on a
    stretch that the other drove through, the finer of the two stays. Of two local maps the one's is kept, and
    of two forays. Forays of a map made along the other side are left out: they are told along that wall.

    Raises: NoMatchError.
    """
    found = compare(one, other) if comparison is None else comparison
    merged = HybridMap(replace(one.meta, loop_closed=one.meta.loop_closed or other.meta.loop_closed))
    for node in one.nodes():
        data = one.graph.nodes[node]
        merged.graph.add_node(node, **{**data, "notes": dict(data["notes"])})
    for arc in one.arcs():
        merged.put_arc(arc)
    number = {partner: node for node, partner in found.matched.items()}
    frames = Frames(one, other, found.matched, found.rotation)
    for partner, node in number.items():
        if merged.graph.nodes[node]["local_map"] is None:
            merged.graph.nodes[node]["local_map"] = _turned(other, partner, found.rotation)
            merged.graph.nodes[node]["entry_heading"] = _heading(other, partner, found.rotation)
    for partner in found.only_other:
        number[partner] = _add(merged, one, other, partner, found.rotation, frames)
    for arc in other.arcs():
        if arc.kind == "foray" and one.meta.side != other.meta.side:
            continue  # how it is driven is told along the other wall
        moved = replace(arc, start=number[arc.start], end=number[arc.end])
        if merged.graph.has_edge(moved.start, moved.end, moved.kind):
            if arc.kind == "foray":
                continue  # another way across between the same nodes
            merged.put_arc(_pooled(merged.arc(moved.start, moved.end, moved.kind), moved))
        elif not _drives_through(merged, moved):
            merged.put_arc(moved)
    _refine(merged)
    return merged


def _pooled(arc: Arc, other: Arc) -> Arc:
    """Mean and variance of all traversals of both, as if driven in one map."""
    count = max(1, arc.traversals), max(1, other.traversals)
    total = count[0] + count[1]
    mean = (arc.distance * count[0] + other.distance * count[1]) / total
    spread = sum(
        n * (known.variance + (known.distance - mean) ** 2)
        for n, known in zip(count, (arc, other), strict=True)
    )
    return replace(
        arc,
        distance=mean,
        variance=spread / total,
        traversals=arc.traversals + other.traversals,
        blocked=arc.blocked and other.blocked,
        notes={**other.notes, **arc.notes},
    )


def _heading(other: HybridMap, partner: int, rotation: float) -> float:
    return float(other.graph.nodes[partner]["entry_heading"] - rotation)


def _turned(other: HybridMap, partner: int, rotation: float) -> LocalMap | None:
    local = other.local_map(partner)
    if local is None:
        return None
    return LocalMap(replace(local.content, entry_heading=local.entry_heading - rotation))


def _add(
    merged: HybridMap, one: HybridMap, other: HybridMap, partner: int, rotation: float, frames: Frames
) -> int:
    data = other.graph.nodes[partner]
    sign = 1.0 if one.meta.side == other.meta.side else -1.0
    node = merged.add_node(
        corner=data["corner"],
        turn=sign * data["turn"],
        entry_heading=_heading(other, partner, rotation),
        local_map=_turned(other, partner, rotation),
        notes=data["notes"],
    )
    if (place := place_in(data["notes"])) is not None:
        merged.annotate(node, **{PLACE: list(frames.moved(place))})
    names = {entry["name"] for _, entry in merged.graph.nodes(data=True)}
    if data["name"] != f"n{partner}" and data["name"] not in names:
        merged.rename(node, data["name"])
    return node


def _drives_through(merged: HybridMap, arc: Arc) -> bool:
    """Whether the merged map has nodes on the stretch of a wall-following arc already."""
    if arc.kind == "foray":
        return False
    most, waiting, seen = 1.2 * arc.distance + SLACK, [(arc.start, 0.0)], {arc.start}
    while waiting:
        node, length = waiting.pop()
        for step in merged.leaving(node):
            if step.kind != arc.kind or step.end in seen or length + step.distance > most:
                continue
            if step.end == arc.end:
                return True
            seen.add(step.end)
            waiting.append((step.end, length + step.distance))
    return False


def _refine(merged: HybridMap) -> None:
    """Leaves each node one arc of a wall: to the nearest node along it, whichever map has that.

    Of two arcs the longer one drives through the nearer one's end. What is left of it from there is kept if
    the merged map lacks it: so are joined a corner that one map has and its neighbor that the other has.
    """
    waiting = [(node, kind) for kind in ("right", "left") for node in merged.nodes()]
    while waiting:
        node, kind = waiting.pop()
        leaving = sorted((arc for arc in merged.leaving(node) if arc.kind == kind), key=_length)
        while len(leaving) > 1:
            near, far = leaving[0], leaving.pop()
            merged.remove_arc(far.start, far.end, kind)
            rest = replace(
                far,
                start=near.end,
                distance=max(far.distance - near.distance, LEAST_REST),
                variance=far.variance + near.variance,
                notes={},
            )
            if rest.start != rest.end and not _drives_through(merged, rest):
                merged.put_arc(rest)
                waiting.append((rest.start, kind))


def _length(arc: Arc) -> float:
    return arc.distance
