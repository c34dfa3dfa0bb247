"""The hybrid map: a topological graph whose nodes carry local maps (sections 3.4.2 and 3.5.1)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import networkx as nx

from .errors import MapError, NoPathError, UnknownNodeError, some
from .local.local_map import LocalMap
from .meta import MapMeta
from .planning import shortest_path
from .sides import other_side
from .storage.store import CORNERS, KINDS, read_file, write_file

_NUMBERED = re.compile(r"n?\d+")

Side = Literal["right", "left"]
Kind = Literal["right", "left", "foray"]
Corner = Literal["concave", "convex", "none"]


@dataclass(frozen=True, slots=True)
class Arc:
    """A way from one node to another: the side to follow, and for how far.

    kind: the arc's key in the graph. distance: mean path length, m. variance: of one traversal, m^2.
    traversals: how often it was driven. notes: free JSON, e.g. the heading of a foray.
    """

    start: int
    end: int
    kind: str
    side: str
    distance: float
    variance: float
    traversals: int = 1
    blocked: bool = False
    notes: Mapping[str, Any] = field(default_factory=dict)


class HybridMap:
    """Owns `graph`, a networkx MultiDiGraph; arcs are keyed by kind: `right`, `left` or `foray`.

    Node attributes: local_map (LocalMap or None), corner (`concave`, `convex`, `none`), turn (rad, signed
    turn of the boundary path there when driven in the mapping direction), entry_heading (rad, map frame),
    name, notes (free JSON). Arc attributes: side, distance (m), variance (m^2), traversals, blocked, notes.
    networkx algorithms may be run on the graph as it is; to change it, use the methods here.
    """

    def __init__(self, meta: MapMeta | None = None) -> None:
        """An empty map."""
        self.meta = meta if meta is not None else MapMeta()
        self.graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()

    # -- building

    def add_node(
        self,
        *,
        corner: str = "none",
        turn: float = 0.0,
        entry_heading: float = 0.0,
        local_map: LocalMap | None = None,
        name: str | None = None,
        notes: Mapping[str, Any] | None = None,
        node: int | None = None,
    ) -> int:
        """Adds a node and returns its number, the next free one unless given. Raises: MapError."""
        number = node if node is not None else max(self.graph, default=-1) + 1
        if number in self.graph or number < 0:
            raise MapError(f"node {number}: numbers are unique and not negative")
        if corner not in CORNERS:
            raise MapError(f"node {number}: unknown corner {corner!r}; known: {', '.join(CORNERS)}")
        _finite(f"node {number}", turn=turn, entry_heading=entry_heading)
        label = f"n{number}" if name is None else name
        if name is not None:
            self._check_name(name, number)
        self.graph.add_node(
            number,
            local_map=local_map,
            corner=corner,
            turn=float(turn),
            entry_heading=float(entry_heading),
            name=label,
            notes=dict(notes or {}),
        )
        return number

    def add_arc(
        self,
        start: int,
        end: int,
        side: str,
        distance: float,
        variance: float = 0.0,
        both_ways: bool = True,
        *,
        kind: str | None = None,
        traversals: int = 1,
        blocked: bool = False,
        notes: Mapping[str, Any] | None = None,
    ) -> Arc:
        """Adds the way from start to end and, both ways, the one back: other side, same length.

        Raises: UnknownNodeError; MapError for a bad value or an arc that exists.
        """
        key = side if kind is None else kind
        self._check_arc(start, end, key, side, distance, variance, traversals)
        ways = [(start, end, key, side)]
        if both_ways:
            back = other_side(side)
            ways.append((end, start, back if key == side else key, back))
        for a, b, arc_key, _ in dict.fromkeys(ways):
            if self.graph.has_edge(a, b, arc_key):
                raise MapError(f"arc {a} -> {b} ({arc_key}) exists already")
        for a, b, arc_key, arc_side in ways:
            self.graph.add_edge(
                a,
                b,
                key=arc_key,
                side=arc_side,
                distance=float(distance),
                variance=float(variance),
                traversals=int(traversals),
                blocked=bool(blocked),
                notes=dict(notes or {}),
            )
        return self.arc(start, end, key)

    def _check_arc(
        self, start: int, end: int, kind: str, side: str, distance: float, variance: float, traversals: int
    ) -> None:
        self._known(start)
        self._known(end)
        where = f"arc {start} -> {end} ({kind})"
        if side not in ("right", "left"):
            raise MapError(f"{where}: unknown side {side!r}; known: right, left")
        if kind not in KINDS or (kind != side and kind != "foray"):
            raise MapError(f"{where}: the kind is the side or foray, not {kind!r}")
        _finite(where, distance=distance, variance=variance)
        if distance < 0.0 or variance < 0.0 or traversals < 0:
            raise MapError(f"{where}: distance, variance and traversals cannot be negative")

    # -- asking

    def nodes(self) -> list[int]:
        """All node numbers in increasing order."""
        return sorted(self.graph)

    def arcs(self) -> Iterator[Arc]:
        """All arcs, ordered by start, end and kind."""
        for start, end, kind in sorted(self.graph.edges(keys=True)):
            yield self.arc(start, end, kind)

    def arc(self, start: int, end: int, kind: str) -> Arc:
        """The arc of that kind. Raises: UnknownNodeError."""
        self._known(start)
        self._known(end)
        if not self.graph.has_edge(start, end, kind):
            there = sorted(self.graph[start].get(end, ()))
            raise UnknownNodeError(f"no arc {start} -> {end} ({kind}); between them: {some(there)}")
        return Arc(start, end, kind, **self.graph.edges[start, end, kind])

    def leaving(self, node: int) -> list[Arc]:
        """The arcs that leave a node, ordered by end and kind. Raises: UnknownNodeError."""
        self._known(node)
        return [self.arc(a, b, kind) for a, b, kind in sorted(self.graph.out_edges(node, keys=True))]

    def next_arc(self, node: int, kind: str) -> Arc | None:
        """The arc of that kind which leaves a node, the first by end if several; None when there is none."""
        return next((arc for arc in self.leaving(node) if arc.kind == kind), None)

    def local_map(self, node: int) -> LocalMap | None:
        """The local map of a node. Raises: UnknownNodeError."""
        self._known(node)
        found: LocalMap | None = self.graph.nodes[node]["local_map"]
        return found

    def find(self, name: str | int) -> int:
        """The node of that number or name; numbers may be given as text. Raises: UnknownNodeError."""
        if isinstance(name, int):
            self._known(name)
            return name
        for node in self.nodes():
            if self.graph.nodes[node]["name"] == name:
                return node
        if name.isascii() and name.isdecimal() and int(name) in self.graph:
            return int(name)
        known = (f"{node} ({self.graph.nodes[node]['name']})" for node in self.nodes())
        raise UnknownNodeError(f"no node {name!r} in this map; known: {some(known)}")

    def path(self, start: int, goal: int) -> list[Arc]:
        """The arcs of the shortest way by distance, blocked ones left out; empty when start is goal.

        A* with a heuristic of zero: the map has no coordinates that would bound a distance from below.
        Raises: UnknownNodeError, NoPathError.
        """
        self._known(start)
        self._known(goal)

        def following(node: int) -> Iterator[tuple[int, float, tuple[int, int, str]]]:
            for a, b, kind in sorted(self.graph.out_edges(node, keys=True)):
                data = self.graph.edges[a, b, kind]
                if not data["blocked"]:
                    yield b, data["distance"], (a, b, kind)

        try:
            steps, _ = shortest_path(start, goal, following)
        except NoPathError:
            raise NoPathError(f"no way from node {start} to node {goal} that is not blocked") from None
        return [self.arc(*step) for step in steps]

    # -- learning and editing

    def record_traversal(
        self, start: int, end: int, kind: str, distance: float, both_ways: bool = True
    ) -> Arc:
        """Lets an arc learn from a path length (m) just driven: running mean and variance (Welford), count.

        The variance an arc was added with counts as one traversal's. The way back is the same path along the
        same wall, so it learns too unless both_ways is False. Raises: UnknownNodeError, MapError.
        """
        arc = self.arc(start, end, kind)
        _finite(f"arc {start} -> {end} ({kind})", distance=distance)
        if distance < 0.0:
            raise MapError(f"arc {start} -> {end} ({kind}): a traversal of {distance} m")
        ways = [(start, end, kind)]
        back = (end, start, kind if kind == "foray" else other_side(kind))
        if both_ways and back != ways[0] and self.graph.has_edge(*back):
            ways.append(back)
        for way in ways:
            data = self.graph.edges[way]
            count = data["traversals"] + 1
            off = distance - data["distance"]
            mean = data["distance"] + off / count
            data["variance"] = (data["variance"] * (count - 1) + off * (distance - mean)) / count
            data["distance"], data["traversals"] = mean, count
        return self.arc(arc.start, arc.end, arc.kind)

    def block(self, start: int, end: int, kind: str, blocked: bool = True) -> None:
        """Marks an arc as blocked, or as free again. Raises: UnknownNodeError."""
        self.arc(start, end, kind)
        self.graph.edges[start, end, kind]["blocked"] = blocked

    def rename(self, node: int, name: str) -> None:
        """Gives a node another name, unique in the map. Raises: UnknownNodeError, MapError."""
        self._known(node)
        self._check_name(name, node)
        self.graph.nodes[node]["name"] = name

    def annotate(self, target: int | tuple[int, int, str], **notes: Any) -> None:
        """Adds free JSON notes to a node, or to an arc given as (start, end, kind); None removes one."""
        if isinstance(target, int):
            self._known(target)
            kept: dict[str, Any] = self.graph.nodes[target]["notes"]
        else:
            self.arc(*target)
            kept = self.graph.edges[target]["notes"]
        for key, value in notes.items():
            if value is None:
                kept.pop(key, None)
            else:
                kept[key] = value

    def remove_node(self, node: int) -> None:
        """Removes a node and its arcs. Raises: UnknownNodeError."""
        self._known(node)
        self.graph.remove_node(node)
        if self.meta.current_node == node:
            self.meta = replace(self.meta, current_node=None, arrival=None)

    def remove_arc(self, start: int, end: int, kind: str) -> None:
        """Removes one arc, not the one back. Raises: UnknownNodeError."""
        self.arc(start, end, kind)
        self.graph.remove_edge(start, end, key=kind)

    # -- storage

    def save(self, path: str | Path, force: bool = False) -> None:
        """Writes one sealed map file. Raises: MapFileExistsError without force, MapFileError."""
        write_file(path, self.meta, self.graph, force=force)

    @classmethod
    def load(cls, path: str | Path) -> HybridMap:
        """Reads a map file; local maps are read on first use. Raises: MapFileError."""
        found = cls()
        found.meta, found.graph = read_file(path)
        return found

    def _known(self, node: int) -> None:
        if node not in self.graph:
            raise UnknownNodeError(f"no node {node} in this map; known: {some(self.nodes())}")

    def _check_name(self, name: str, node: int) -> None:
        if _NUMBERED.fullmatch(name) and name != f"n{node}":
            raise MapError(f"node {node} cannot be named {name!r}: that means another node's number")
        if not name or len(name) > 200 or not name.isprintable():
            raise MapError(f"a node's name must be 1 to 200 printable characters, not {name[:40]!r}")
        for other, data in self.graph.nodes(data=True):
            if other != node and data["name"] == name:
                raise MapError(f"the name {name!r} is taken by node {other}")


def _finite(where: str, **values: float) -> None:
    for name, value in values.items():
        if not math.isfinite(value):
            raise MapError(f"{where}: {name} = {value} is not a finite number")
