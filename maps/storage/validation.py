"""What is wrong with a map file, and what of it can be saved."""

from __future__ import annotations

import os
import sqlite3
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import MapError, MapFileError
from ..fields import ARC, NODE
from ..meta import MapMeta
from . import migration
from .graph import check_arc, read_graph
from .reader import MAX_NODES, check_all_digests, damage, fits, open_map, open_unchecked, read_tensors
from .rows import from_row
from .schema import CURRENT
from .unpacking import StoredLocalMaps, read_local_map
from .values import dump_json, parse_json, parse_object, row_hash
from .writer import RowWriter, drafting

MOST_PROBLEMS = 50


@dataclass(frozen=True, slots=True)
class Validation:
    """problems: one line each, none when all is well. savable_*: what `recover` would write."""

    problems: tuple[str, ...]
    savable_nodes: int
    savable_arcs: int
    savable_local_maps: int

    @property
    def valid(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems


@dataclass(slots=True)
class _Salvage:
    """Rows whose own checksums hold, whatever else is wrong."""

    rows: dict[str, list[tuple[Any, ...]]]
    tensors: dict[int, bytes]
    lost: list[str]


def validate(path: str | os.PathLike[str]) -> Validation:
    """Checks everything in a map file, every local map's bytes included; reads it all, writes nothing.

    Raises: MapFileError when there is no file to read.
    """
    target = Path(path)
    if not target.is_file():
        raise MapFileError(f"{target}: there is no such file")
    if migration.FORMATS.older(target) is not None:
        return _of_older_version(target)
    problems: list[str] = []
    try:
        connection = open_map(target)
    except MapFileError as error:
        problems.append(_bare(error, target))
    else:
        try:
            problems += _all_problems(connection, target)
        finally:
            connection.close()
    if not problems:
        nodes, arcs, maps = _count(target)
        return Validation((), nodes, arcs, maps)
    try:
        found = _salvage(target)
    except MapFileError as error:
        return Validation((*problems, f"nothing can be saved: {_bare(error, target)}"), 0, 0, 0)
    problems += [line for line in found.lost if line not in problems]
    return Validation(
        tuple(problems[:MOST_PROBLEMS]), len(found.rows["node"]), len(found.rows["arc"]), len(found.tensors)
    )


def recover(path: str | os.PathLike[str], output: str | os.PathLike[str], force: bool = False) -> Validation:
    """Writes what can be saved of a file to another, sealed one; says what was wrong and what was saved.

    Nodes, arcs and local maps are kept when their own checksums hold; an arc needs both its nodes, a node
    whose local map is damaged is kept without it. A file of an older format version is brought up to date.

    Raises: MapFileError when nothing can be saved, MapFileExistsError.
    """
    target, goal = Path(path), Path(output)
    if goal.exists() and target.exists() and goal.samefile(target):
        raise MapFileError(
            f"{goal}: recovering a file onto itself would lose what cannot be read; name another"
        )
    if migration.FORMATS.older(target) is not None:
        done = migration.migrate(target, goal, force)
        return Validation((_VERSION.format(done.version),), done.nodes, done.arcs, done.local_maps)
    about = validate(target)
    found = _salvage(target)
    with drafting(goal, force) as writer:
        _write(found, writer)
    return about


_VERSION = "format version {}: an older one, `tolman validate FILE --recover OUT` brings it up to date"


def _of_older_version(path: Path) -> Validation:
    """Brings the file over into a folder that is thrown away, to know what is in it."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            done = migration.migrate(path, Path(folder) / "new.tolman")
        except MapFileError as error:
            return Validation((_bare(error, path), "nothing can be saved"), 0, 0, 0)
    return Validation((_VERSION.format(done.version),), done.nodes, done.arcs, done.local_maps)


def _bare(error: Exception, path: Path) -> str:
    return str(error).removeprefix(f"{path}: ")


def _all_problems(connection: sqlite3.Connection, path: Path) -> Iterator[str]:
    for check in (_sqlite_problems, _graph_problems, _local_map_problems):
        try:
            with damage(path):
                yield from check(connection, path)
        except MapFileError as error:
            yield _bare(error, path)


def _sqlite_problems(connection: sqlite3.Connection, path: Path) -> Iterator[str]:
    for (line,) in connection.execute("PRAGMA integrity_check(20)").fetchall():
        if line != "ok":
            yield f"SQLite: {' '.join(str(line).split())}"


def _graph_problems(connection: sqlite3.Connection, path: Path) -> Iterator[str]:
    check_all_digests(connection)
    read_graph(connection, StoredLocalMaps(path))
    for node, text in connection.execute("SELECT node, data FROM truth"):
        try:
            parse_object(text, f"truth of node {node}", 1 << 20)
        except MapError as error:
            yield str(error)


def _local_map_problems(connection: sqlite3.Connection, path: Path) -> Iterator[str]:
    manifests = connection.execute("SELECT id, local_map FROM node WHERE local_map IS NOT NULL").fetchall()
    for node, manifest in manifests:
        try:
            if type(node) is int and type(manifest) is str:
                read_local_map(connection, node, manifest)
        except (MapError, sqlite3.Error) as error:
            yield str(error)
    query = (
        "SELECT count(*) FROM tensors LEFT JOIN node ON node.id = tensors.node WHERE node.local_map IS NULL"
    )
    ((extra,),) = connection.execute(query)
    if extra:
        yield f"{extra} local map(s) belong to no node"


def _count(path: Path) -> tuple[int, int, int]:
    connection = open_map(path)
    try:
        nodes, arcs, maps = (
            int(connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0])
            for table in ("node", "arc", "tensors")
        )
    finally:
        connection.close()
    return nodes, arcs, maps


def _salvage(path: Path) -> _Salvage:
    """Every row that can still be read and whose checksum holds. Raises: MapFileError."""
    connection = open_unchecked(path)
    try:
        found = _Salvage({}, {}, [])
        for table in CURRENT.columns:
            found.rows[table] = _good_rows(connection, table, found.lost)
        _drop_misfits(found)
        for position, row in enumerate(found.rows["node"]):
            if row[-1] is None:
                continue
            try:
                read_local_map(connection, row[0], row[-1])
                found.tensors[row[0]] = read_tensors(connection, row[0])
            except (MapError, sqlite3.Error, MemoryError):
                found.lost.append(f"node {row[0]}: its local map is damaged and left out")
                found.rows["node"][position] = (*row[:-1], None)
        return found
    finally:
        connection.close()


def _good_rows(connection: sqlite3.Connection, table: str, lost: list[str]) -> list[tuple[Any, ...]]:
    columns = ", ".join(CURRENT.columns[table])
    good: dict[Any, tuple[Any, ...]] = {}
    bad = 0
    for direction in ("ASC", "DESC"):  # damage in the middle stops a scan: come from the other end too
        order = ", ".join(f"{column} {direction}" for column in CURRENT.key(table))
        try:
            for row in connection.execute(f"SELECT {columns}, hash FROM {table} ORDER BY {order}"):
                if fits(row, CURRENT.types[table]) and row_hash(table, row[:-1]) == row[-1]:
                    good[row[: CURRENT.keys[table]]] = row[:-1]
                else:
                    bad += 1
                if len(good) + bad > 2 * MAX_NODES:
                    break
        except (sqlite3.Error, OverflowError, UnicodeError) as error:
            lost.append(f"table {table}: cannot be read to its end: {error}")
            continue
        break
    if bad:
        lost.append(f"table {table}: {bad} row(s) whose checksum does not match")
    return [good[key] for key in sorted(good)]


def _drop_misfits(found: _Salvage) -> None:
    """Drops rows with impossible values and arcs to nodes that are lost; gives the meta what it lacks."""
    names: set[str] = set()
    kept = []
    for row in found.rows["node"]:
        name = _node_name(row)
        if name is not None and name not in names:
            names.add(name)
            kept.append(row)
    _note_lost(found, "node(s) have impossible values", len(kept) - len(found.rows["node"]))
    found.rows["node"] = kept
    known = {row[0] for row in kept}
    arcs = [row for row in found.rows["arc"] if row[0] in known and row[1] in known and _arc_fits(row)]
    _note_lost(found, "arc(s) lead to nodes that are lost", len(arcs) - len(found.rows["arc"]))
    found.rows["arc"] = arcs
    for table, column in (("truth", 1), ("ext", 2)):
        rows = [row for row in found.rows[table] if _is_json(row[column], table == "truth")]
        _note_lost(found, f"row(s) of table {table} hold no JSON", len(rows) - len(found.rows[table]))
        found.rows[table] = rows
    found.rows["meta"] = [
        (key, dump_json(value, f"meta {key}")) for key, value in _whole_meta(found, known).items()
    ]


def _note_lost(found: _Salvage, what: str, change: int) -> None:
    if change:
        found.lost.append(f"{-change} {what}")


def _whole_meta(found: _Salvage, known: set[int]) -> dict[str, Any]:
    blank = MapMeta().to_json()
    have = {key: value for key, value in found.rows["meta"] if key in blank}
    values: dict[str, Any] = {}
    for key, default in blank.items():
        try:
            values[key] = parse_json(have[key], f"meta {key}")
            MapMeta.from_json({**blank, key: values[key]})
        except (KeyError, MapError):
            values[key] = default
            found.lost.append(f"meta {key} is lost")
    if values["current_node"] not in known:
        values["current_node"] = values["arrival"] = None
    return values


def _node_name(row: tuple[Any, ...]) -> str | None:
    try:
        return str(from_row(NODE, row)[1]["name"])
    except MapError:
        return None


def _arc_fits(row: tuple[Any, ...]) -> bool:
    try:
        from_row(ARC, row)
        check_arc(row)
    except MapError:
        return False
    return True


def _is_json(text: str, table: bool) -> bool:
    try:
        (parse_object if table else parse_json)(text, "it", 1 << 20)
    except MapError:
        return False
    return True


def _write(found: _Salvage, writer: RowWriter) -> None:
    for table, rows in found.rows.items():
        for row in rows:
            writer.put(table, row)
    for node, data in found.tensors.items():
        writer.put_tensors(node, data)
