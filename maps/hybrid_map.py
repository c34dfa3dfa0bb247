"""The hybrid map: a topological graph whose nodes carry local maps (sections 3.4.2 and 3.5.1)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Unpack

import networkx as nx

from .errors import MapError, NoPathError, UnknownNodeError, some
from .fields import ARC, NODE, Arc, NodeValues, Record
from .meta import MapMeta
from .planning import shortest_path
from .sides import other_side

if TYPE_CHECKING:
    from .local.local_map import LocalMap

__all__ = ["Arc", "HybridMap", "Storage"]

_NUMBERED = re.compile(r"n?\d+")


class Storage(Protocol):
    """Reads and writes whole maps. `maps.storage` lies above the graph, so it is told here which one does."""

    def write(self, path: str | Path, meta: MapMeta, graph: nx.MultiDiGraph[int], force: bool) -> None:
        """Writes a file. Raises: MapFileExistsError without force, MapFileError, MapError."""

    def read(self, path: str | Path) -> tuple[MapMeta, nx.MultiDiGraph[int]]:
        """Meta and graph of a file. Raises: MapFileError."""
        ...


class HybridMap:
    """Owns `graph`, a networkx MultiDiGraph; arcs are keyed by kind: `right`, `left` or `foray`.

    Node attributes: local_map (LocalMap or None) and those of `NodeValues`: name, corner (`concave`,
    `convex`, `none`), turn (rad), entry_heading (rad, map frame), notes (free JSON). Arc attributes: those of
    `Arc` that are no key. networkx algorithms may be run on the graph as it is; to change it, use the methods
    here.
    """

    storage: ClassVar[Storage]

    def __init__(self, meta: MapMeta | None = None) -> None:
        """An empty map."""
        self.meta = meta if meta is not None else MapMeta()
        self.graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()

    def __repr__(self) -> str:
        """What there is in it: `HybridMap('env1', 10 nodes, 20 arcs, 10 local maps, closed)`."""
        maps = sum(data.get("local_map") is not None for _, data in self.graph.nodes(data=True))
        counts = [_count(len(self.graph), "node"), _count(self.graph.number_of_edges(), "arc")]
        told = [repr(self.meta.world), *counts, _count(maps, "local map")]
        return f"HybridMap({', '.join(told)}, {'closed' if self.meta.loop_closed else 'open'})"

    # -- building

    def add_node(
        self,
        *,
        node: int | None = None,
        local_map: LocalMap | None = None,
        **values: Unpack[NodeValues],
    ) -> int:
        """Adds a node and returns its number, the next free one unless given. Raises: MapError."""
        number = node if node is not None else max(self.graph, default=-1) + 1
        name = values.get("name")
        clean = _clean(NODE, (number,), {**values, "name": f"n{number}" if name is None else name})
        if number in self.graph:
            raise MapError(f"node {number} exists already")
        if name is not None:
            self._check_name(name, number)
        self.graph.add_node(number, local_map=local_map, **clean)
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
        **values: Any,
    ) -> Arc:
        """Adds the way from start to end and, both ways, the one back: other side, same length.

        values: further fields of `Arc`: traversals, blocked, notes.
        Raises: UnknownNodeError; MapError for a bad value or an arc that exists.
        """
        key = side if kind is None else kind
        values = {**values, "distance": distance, "variance": variance}
        ways = {(start, end, key): side}
        if both_ways:
            back = other_side(side)
            ways[end, start, back if key == side else key] = back
        clean = {way: self._check_arc(way, {**values, "side": wall}) for way, wall in ways.items()}
        for (a, b, arc_key), kept in clean.items():
            self.graph.add_edge(a, b, key=arc_key, **kept)
        return self.arc(start, end, key)

    def put_arc(self, arc: Arc) -> None:
        """Adds an arc, or replaces the one of its kind. Raises: UnknownNodeError, MapError."""
        key = arc.start, arc.end, arc.kind
        self.graph.add_edge(*key[:2], key=arc.kind, **self._check_arc(key, arc.values(), new=False))

    def _check_arc(
        self, key: tuple[int, int, str], values: dict[str, Any], new: bool = True
    ) -> dict[str, Any]:
        clean = _clean(ARC, key, values)
        self._known(key[0])
        self._known(key[1])
        if key[2] not in (clean["side"], "foray"):
            raise MapError(f"{ARC.label(key)}: the kind is the side or foray, not {key[2]!r}")
        if new and self.graph.has_edge(*key):
            raise MapError(f"{ARC.label(key)} exists already")
        return clean

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
        _clean(ARC, (start, end, kind), {**arc.values(), "distance": distance})
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
        self.graph.edges[start, end, kind]["blocked"] = bool(blocked)

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
        """Writes one sealed map file. Raises: MapFileExistsError without force, MapFileError, MapError."""
        self.storage.write(path, self.meta, self.graph, force)

    @classmethod
    def load(cls, path: str | Path) -> HybridMap:
        """Reads a map file; local maps are read on first use. Raises: MapFileError."""
        found = cls()
        found.meta, found.graph = cls.storage.read(path)
        return found

    def _known(self, node: int) -> None:
        if node not in self.graph:
            raise UnknownNodeError(f"no node {node} in this map; known: {some(self.nodes())}")

    def _check_name(self, name: str, node: int) -> None:
        _clean(NODE, (node,), {"name": name})
        if _NUMBERED.fullmatch(name) and name != f"n{node}":
            raise MapError(f"node {node} cannot be named {name!r}: that means another node's number")
        for other, data in self.graph.nodes(data=True):
            if other != node and data["name"] == name:
                raise MapError(f"the name {name!r} is taken by node {other}")


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _clean(record: Record, key: tuple[Any, ...], values: dict[str, Any]) -> dict[str, Any]:
    try:
        return record.clean(key, values)
    except ValueError as error:
        raise MapError(str(error)) from None
