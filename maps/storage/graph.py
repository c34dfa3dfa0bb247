"""The graph and the meta to the rows of an open map database and back."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import networkx as nx

from ..errors import MapError, MapFileDamagedError
from ..fields import ARC, NODE
from ..local.local_map import LocalMap
from ..meta import MapMeta
from .packing import pack_local_map
from .reader import MAX_ARCS_PER_NODE, MAX_NODES, read_rows
from .rows import from_row, to_row
from .values import dump_json, parse_json

if TYPE_CHECKING:
    from .writer import RowWriter

Key = tuple[int, int, str]
LocalMaps = Callable[[int, str], LocalMap]
"""Gives the local map of a node whose row has that manifest."""


def put_meta(writer: RowWriter, meta: MapMeta) -> None:
    """Writes the meta rows, one a field."""
    for name, value in meta.to_json().items():
        writer.put("meta", (name, dump_json(value, f"meta {name}")))


def put_node(writer: RowWriter, graph: nx.MultiDiGraph[int], node: int) -> None:
    """Writes one node and its local map. Raises: MapError when it cannot be stored."""
    values = dict(graph.nodes[node])
    local = values.pop("local_map", None)
    row = to_row(NODE, (node,), values)
    if local is not None and not isinstance(local, LocalMap):
        raise MapError(f"node {node}: its local map is a {type(local).__name__}, not a LocalMap")
    manifest, tensors = (None, None) if local is None else pack_local_map(local.content)
    if writer.put(
        "node", (*row, manifest)
    ):  # the row holds its local map's hash: unchanged, so are the bytes
        writer.put_tensors(node, tensors)


def put_arc(writer: RowWriter, graph: nx.MultiDiGraph[int], key: Key) -> None:
    """Writes one arc. Raises: MapError when it cannot be stored."""
    check_arc(row := to_row(ARC, key, graph.edges[key]))
    writer.put("arc", row)


def check_arc(row: tuple[object, ...]) -> None:
    """Raises: MapError when the kind of an arc, its third value, is not that of its side, the fourth."""
    if row[2] not in (row[3], "foray"):
        raise MapError(f"{ARC.label(row[:3])}: the kind is the side or foray, and its side is {row[3]}")


def check_references(
    connection: sqlite3.Connection, meta: MapMeta, nodes: Iterable[int], arcs: Iterable[Key]
) -> None:
    """Checks what a commit leaves behind: no arc and no robot at a node that is not there. Raises: MapError.

    nodes: those that may be gone. arcs: those that may be new.
    """
    if meta.current_node is not None and not has_node(connection, meta.current_node):
        raise MapError(f"the robot is said to be at node {meta.current_node}, which is not in the map")
    for node in nodes:
        arc = connection.execute('SELECT 1 FROM arc WHERE start = ? OR "end" = ?', (node, node)).fetchone()
        if arc is not None and not has_node(connection, node):
            raise MapError(f"node {node} was removed, but arcs from or to it are kept")
    for start, end, kind in arcs:
        there = connection.execute('SELECT "end", kind FROM arc WHERE start = ?', (start,)).fetchall()
        if (end, kind) in there and not (has_node(connection, start) and has_node(connection, end)):
            raise MapError(f"{ARC.label((start, end, kind))} leads from or to a node that is not in the map")
        _refuse_many_arcs(start, len(there))


def has_node(connection: sqlite3.Connection, node: int) -> bool:
    """Whether a node is stored."""
    return connection.execute("SELECT 1 FROM node WHERE id = ?", (node,)).fetchone() is not None


def read_graph(connection: sqlite3.Connection, local_maps: LocalMaps) -> tuple[MapMeta, nx.MultiDiGraph[int]]:
    """Meta and graph from an open map database, everything verified but the local maps' bytes.

    Raises: MapError, sqlite3.Error.
    """
    meta = read_meta(connection)
    graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()
    rows, names = read_rows(connection, "node"), set()
    if len(rows) > MAX_NODES:
        raise MapFileDamagedError(f"{len(rows)} nodes: at most {MAX_NODES}")
    for row in rows:
        (node,), values = from_row(NODE, row)
        if values["name"] in names:
            raise MapFileDamagedError(f"node {node}: its name {values['name']!r:.40} is another's too")
        names.add(values["name"])
        graph.add_node(node, local_map=None if row[-1] is None else local_maps(node, row[-1]), **values)
    for row in read_rows(connection, "arc"):
        (start, end, kind), values = from_row(ARC, row)
        check_arc(row)
        if start not in graph or end not in graph:
            raise MapFileDamagedError(f"{ARC.label(row[:3])} leads to a node that is not there")
        graph.add_edge(start, end, key=kind, **values)
    for start, count in graph.out_degree:
        _refuse_many_arcs(start, count)
    if meta.current_node is not None and meta.current_node not in graph:
        raise MapFileDamagedError(
            f"the robot is said to be at node {meta.current_node}, which does not exist"
        )
    return meta, graph


def read_meta(connection: sqlite3.Connection) -> MapMeta:
    """What the map says about itself. Raises: MapError."""
    return MapMeta.from_json(
        {key: parse_json(value, f"meta {key:.40}") for key, value in read_rows(connection, "meta")}
    )


def _refuse_many_arcs(node: int, count: int) -> None:
    if count > MAX_ARCS_PER_NODE:
        raise MapError(f"node {node} has {count} arcs: at most {MAX_ARCS_PER_NODE}")
