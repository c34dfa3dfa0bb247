"""Graphs to rows and back, and whole maps to sealed files and back."""

from __future__ import annotations

import os
import sqlite3
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any

import networkx as nx

from ..errors import MapError, MapFileDamagedError, MapFileError, MapFileExistsError
from ..local.local_map import LocalMap
from ..meta import MapMeta
from .locking import Lock
from .reader import MAX_ARCS_PER_NODE, MAX_NODES, TensorReader, damage, open_map, read_rows
from .records import ArcRow, NodeRow, dump_json, pack_local_map, parse_json, parse_object
from .schema import CURRENT, Schema
from .writer import RowWriter, create_tables, file_errors, replace_file, sibling, transaction, write_copy

CORNERS = ("concave", "convex", "none")
KINDS = ("right", "left", "foray")


def put_meta(writer: RowWriter, meta: MapMeta) -> None:
    """Writes the meta rows, one a field."""
    for name, value in meta.to_json().items():
        writer.put("meta", (name, dump_json(value, f"meta {name}")))


def put_node(writer: RowWriter, graph: nx.MultiDiGraph[int], node: int) -> None:
    """Writes one node and its local map. Raises: MapError when it cannot be stored."""
    data = graph.nodes[node]
    local: LocalMap | None = data["local_map"]
    manifest, tensors = (None, None) if local is None else pack_local_map(local.content)
    row = NodeRow(
        node,
        str(data["name"]),
        str(data["corner"]),
        float(data["turn"]),
        float(data["entry_heading"]),
        dump_json(data["notes"], f"node {node}: notes"),
        manifest,
    )
    check_node(row)
    if writer.put("node", row):  # the row holds its local map's hash: unchanged, so are the bytes
        writer.put_tensors(node, tensors)


def put_arc(writer: RowWriter, graph: nx.MultiDiGraph[int], key: tuple[int, int, str]) -> None:
    """Writes one arc. Raises: MapError when it cannot be stored."""
    data = graph.edges[key]
    row = ArcRow(
        *key,
        str(data["side"]),
        float(data["distance"]),
        float(data["variance"]),
        int(data["traversals"]),
        int(data["blocked"]),
        dump_json(data["notes"], f"arc {key}: notes"),
    )
    check_arc(row)
    writer.put("arc", row)


def check_node(row: NodeRow) -> None:
    """Raises: MapError when a node's values are not ones a map may have."""
    if row.id < 0 or not row.name or len(row.name) > 200 or not row.name.isprintable():
        raise MapError(f"node {row.id}: numbers from 0, names of 1 to 200 printable characters")
    if row.corner not in CORNERS or not isfinite(row.turn) or not isfinite(row.entry_heading):
        raise MapError(f"node {row.id}: corner {row.corner!r}, turn {row.turn}, heading {row.entry_heading}")


def check_arc(row: ArcRow) -> None:
    """Raises: MapError when an arc's values are not ones a map may have."""
    where = f"arc {row.start} -> {row.end} ({row.kind})"
    if row.kind not in KINDS or row.side not in KINDS[:2] or row.kind not in (row.side, "foray"):
        raise MapError(
            f"{where}: side {row.side!r}, expected right or left and the kind to be the side or foray"
        )
    numbers = (row.distance, row.variance)
    if not all(isfinite(value) and value >= 0.0 for value in numbers) or row.traversals < 0:
        raise MapError(f"{where}: distance, variance and traversals must be finite and not negative")
    if row.blocked not in (0, 1):
        raise MapError(f"{where}: blocked is {row.blocked}, expected 0 or 1")


def write_file(
    path: str | os.PathLike[str], meta: MapMeta, graph: nx.MultiDiGraph[int], force: bool = False
) -> None:
    """Writes one sealed file: same content, same bytes.

    Raises: MapFileExistsError, MapFileError, MapError.
    """
    with drafting(Path(path), force) as writer:
        put_meta(writer, meta)
        for node in sorted(graph):
            put_node(writer, graph, node)
        for key in sorted(graph.edges(keys=True)):
            put_arc(writer, graph, key)


@contextmanager
def drafting(target: Path, force: bool = False, schema: Schema = CURRENT) -> Iterator[RowWriter]:
    """Writes a whole new file through the writer it yields; `target` appears at the end or not at all.

    Raises: MapFileExistsError without force, MapFileError.
    """
    if target.exists() and not force:
        raise MapFileExistsError(f"{target} exists already; force overwrites it")
    if not target.parent.is_dir():
        raise MapFileError(f"{target}: the folder {target.parent} does not exist")
    draft = sibling(target, ".draft")
    with file_errors(target, "write"), Lock.held(target):
        draft.unlink(missing_ok=True)
        try:
            connection = sqlite3.connect(draft, isolation_level=None)
            try:
                connection.execute("PRAGMA journal_mode = OFF")
                connection.execute("PRAGMA synchronous = OFF")
                create_tables(connection, schema)
                with transaction(connection, schema) as writer:
                    yield writer
                part = write_copy(connection, target)
            finally:
                connection.close()
            replace_file(part, target)
            for ending in ("-wal", "-shm", "-journal"):
                sibling(target, ending).unlink(missing_ok=True)
        finally:
            draft.unlink(missing_ok=True)


def read_file(path: str | os.PathLike[str]) -> tuple[MapMeta, nx.MultiDiGraph[int]]:
    """Meta and graph of a map file; local maps are read and verified on first use.

    Raises: MapFileError, MapFileDamagedError.
    """
    target = Path(path)
    connection = open_map(target)
    with damage(target):
        try:
            connection.execute("BEGIN")
            meta, graph = read_graph(connection, target)
            connection.execute("COMMIT")
        except BaseException:
            connection.close()
            raise
    return meta, graph


def read_graph(
    connection: sqlite3.Connection, path: Path, keep: bool = True
) -> tuple[MapMeta, nx.MultiDiGraph[int]]:
    """Meta and graph from an open map database, everything verified but the local maps' bytes.

    Local maps are read later through this connection, or through ones of their own without `keep`.
    """
    meta = read_meta(connection)
    reader = TensorReader(path, connection if keep else None)
    graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()
    nodes = [NodeRow(*row) for row in read_rows(connection, "node")]
    arcs = [ArcRow(*row) for row in read_rows(connection, "arc")]
    if len(nodes) > MAX_NODES:
        raise MapFileDamagedError(f"{len(nodes)} nodes: at most {MAX_NODES}")
    _refuse_bad_values(nodes, arcs)
    for node in nodes:
        graph.add_node(
            node.id,
            local_map=None if node.local_map is None else LocalMap(_Load(reader, node.id)),
            corner=node.corner,
            turn=node.turn,
            entry_heading=node.entry_heading,
            name=node.name,
            notes=_notes(node.notes, f"node {node.id}"),
        )
    for arc in arcs:
        graph.add_edge(
            arc.start,
            arc.end,
            key=arc.kind,
            side=arc.side,
            distance=arc.distance,
            variance=arc.variance,
            traversals=arc.traversals,
            blocked=bool(arc.blocked),
            notes=_notes(arc.notes, f"arc {arc.start} -> {arc.end}"),
        )
    if meta.current_node is not None and meta.current_node not in graph:
        raise MapFileDamagedError(
            f"the robot is said to be at node {meta.current_node}, which does not exist"
        )
    return meta, graph


def read_meta(connection: sqlite3.Connection) -> MapMeta:
    """What the map says about itself. Raises: MapFileDamagedError."""
    values = {key: parse_json(value, f"meta {key}") for key, value in read_rows(connection, "meta")}
    try:
        return MapMeta.from_json(values)
    except MapError as error:
        raise MapFileDamagedError(str(error)) from None


def _notes(text: str, what: str) -> dict[str, Any]:
    return {} if text == "{}" else parse_object(text, f"{what}: notes")


def _refuse_bad_values(nodes: list[NodeRow], arcs: list[ArcRow]) -> None:
    try:
        for node in nodes:
            check_node(node)
        for arc in arcs:
            check_arc(arc)
    except MapError as error:
        raise MapFileDamagedError(str(error)) from None
    known = {node.id for node in nodes}
    for arc in arcs:
        if arc.start not in known or arc.end not in known:
            raise MapFileDamagedError(
                f"arc {arc.start} -> {arc.end} ({arc.kind}) leads to a node that is not there"
            )
    for start, count in Counter(arc.start for arc in arcs).items():
        if count > MAX_ARCS_PER_NODE:
            raise MapFileDamagedError(f"node {start} has {count} arcs: at most {MAX_ARCS_PER_NODE}")


class _Load:
    """Reads one local map when called; kept instead of a closure so that maps can be copied."""

    def __init__(self, reader: TensorReader, node: int) -> None:
        self._reader = reader
        self._node = node

    def __call__(self) -> Any:
        return self._reader.read(self._node)
