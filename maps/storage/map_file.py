"""A map file that grows while the robot maps: what `append` has returned from is on disk."""

from __future__ import annotations

import contextlib
import os
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from urllib.parse import quote

from ..errors import MapError, MapFileDamagedError, MapFileError, MapFileExistsError
from ..hybrid_map import HybridMap
from ..meta import MapMeta
from .locking import Lock
from .reader import check_all_digests, check_schema, check_version, damage, open_map, read_rows
from .records import dump_json, parse_json, parse_object
from .store import put_arc, put_meta, put_node, read_graph
from .writer import (
    RowWriter,
    create_tables,
    file_errors,
    replace_file,
    sibling,
    sync_folder,
    transaction,
    write_copy,
)

State = bytes | Mapping[str, Any] | None

STATE_LIMIT = 16 << 20
TRUTH_LIMIT = 1 << 20
RUN = -1
"""The row of the truth table that is about the run as a whole."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What only scoring may know. nodes: node -> JSON object, e.g. the true pose; run: about all of it."""

    nodes: dict[int, dict[str, Any]]
    run: dict[str, Any]


class MapFile:
    """One writer's hold on a map file. Viewers may read beside it. Use as a context manager, or `seal`.

    `append` and `update` are one transaction each; a kill or a power cut at any moment leaves the last one
    that returned. `seal` turns the file into its canonical form: same content, same bytes.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection, lock: Lock) -> None:
        """Not to be called: see `create` and `resume`."""
        self.path = path
        self.map = HybridMap()
        self.state: bytes | dict[str, Any] | None = None
        self._connection: sqlite3.Connection | None = connection
        self._lock = lock

    @classmethod
    def create(cls, path: str | os.PathLike[str], meta: MapMeta | None = None, force: bool = False) -> Self:
        """Begins a new file. Raises: MapFileExistsError without force, MapFileLockedError, MapFileError."""
        target = Path(path)
        if not target.parent.is_dir():
            raise MapFileError(f"{target}: the folder {target.parent} does not exist")
        if target.exists() and not (force and target.is_file()):
            raise MapFileExistsError(
                f"{target} exists already; --force overwrites it, --resume goes on with it"
            )
        with file_errors(target, "create"):
            lock = Lock.acquire(target)
            try:
                _remove(target)
                connection = _connect(target)
                create_tables(connection)
                with transaction(connection) as writer:
                    put_meta(writer, meta or MapMeta())
                _begin_wal(connection)
                sync_folder(target)
            except BaseException:
                lock.release()
                raise
        file = cls(target, connection, lock)
        file.map.meta = meta or MapMeta()
        return file

    @classmethod
    def resume(cls, path: str | os.PathLike[str]) -> Self:
        """Goes on with a file, sealed or not: `map` and `state` are what was committed last.

        Raises: MapFileError, MapFileDamagedError, MapFileLockedError.
        """
        target = Path(path)
        if not target.is_file():
            raise MapFileError(f"{target}: there is no such file to resume")
        with file_errors(target, "resume"):
            lock = Lock.acquire(target)
        try:
            with file_errors(target, "resume"), damage(target):
                connection = _connect(target, create=False)
                check_version(connection)
                check_schema(connection)
                check_all_digests(connection)
                file = cls(target, connection, lock)
                file.map.meta, file.map.graph = read_graph(connection, target, keep=False)
                file.state = _read_state(connection)
                _begin_wal(connection)
        except BaseException:
            lock.release()
            raise
        return file

    def append(
        self, hybrid: HybridMap, node: int, *, state: State = None, truth: Mapping[str, Any] | None = None
    ) -> None:
        """Commits a node of `hybrid`, its local map, every arc from or to it, and the meta.

        state: the session's state as bytes or JSON object, so that a resumed run goes on exactly (None keeps
        the one there is). truth: JSON object for the node's row in the section that maps never read.
        When this returns the node is on disk.

        Raises: MapError, MapFileError; the file then keeps what it had.
        """
        arcs = [*hybrid.graph.in_edges(node, keys=True), *hybrid.graph.out_edges(node, keys=True)]
        self.update(hybrid, [node], arcs, state=state, truth=None if truth is None else {node: truth})

    def update(
        self,
        hybrid: HybridMap,
        nodes: Iterable[int] = (),
        arcs: Iterable[tuple[int, int, str]] = (),
        *,
        state: State = None,
        truth: Mapping[int, Mapping[str, Any]] | None = None,
    ) -> None:
        """Commits the meta and those nodes and arcs as they are in `hybrid`; those gone from it are deleted.

        truth: JSON objects by node; the key -1 (`RUN`) is about the run as a whole.
        Raises: MapError, MapFileError.
        """
        with file_errors(self.path, "save"), transaction(self._open()) as writer:
            put_meta(writer, hybrid.meta)
            for node in sorted(set(nodes)):
                if node in hybrid.graph:
                    put_node(writer, hybrid.graph, node)
                else:
                    writer.delete("node", (node,))
                    writer.put_tensors(node, None)
            for key in sorted(set(arcs)):
                if hybrid.graph.has_edge(*key):
                    put_arc(writer, hybrid.graph, key)
                else:
                    writer.delete("arc", key)
            _put_state(writer, state)
            for node, data in sorted((truth or {}).items()):
                writer.put("truth", (node, dump_json(dict(data), f"truth of node {node}", TRUTH_LIMIT)))

    def put_extension(self, owner: str, key: str, value: Any) -> None:
        """Commits a third party's JSON value (at most 4096 characters) under its own name."""
        with file_errors(self.path, "save"), transaction(self._open()) as writer:
            writer.put("ext", (owner, key, dump_json(value, f"extension {owner}/{key}")))

    def seal(self) -> None:
        """Writes the canonical file in place of the growing one and lets go of it. Twice does nothing.

        Raises: MapFileError when there is no room for the copy or a viewer does not let go; what was saved is
        kept in the unsealed file, which can be resumed.
        """
        if self._connection is None:
            return
        try:
            with file_errors(self.path, "seal"):
                part = write_copy(self._connection, self.path)
                _drain(self._connection, self.path)
                self._connection.close()
                replace_file(part, self.path)
                _remove(self.path, ENDINGS)
        finally:
            self.close()

    def close(self) -> None:
        """Lets go of the file without sealing it. Twice does nothing."""
        if self._connection is not None:
            with contextlib.suppress(sqlite3.Error):
                # The last one to close removes the -wal: the file must then not say that it has one.
                self._connection.execute("PRAGMA journal_mode = DELETE")
            self._connection.close()
            self._connection = None
            self._lock.release()

    def __enter__(self) -> Self:
        """The file itself; it is sealed at the end of the block, or just closed when the block raises."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Seals the file, or only closes it when an exception is under way."""
        if kind is None:
            self.seal()
        else:
            self.close()

    def _open(self) -> sqlite3.Connection:
        if self._connection is None:
            raise MapFileError(f"{self.path}: already sealed or closed")
        return self._connection


def read_truth(path: str | os.PathLike[str]) -> Truth:
    """The truth section of a map file. Raises: MapFileError, MapFileDamagedError."""
    target = Path(path)
    connection = open_map(target)
    try:
        with damage(target):
            rows = dict(read_rows(connection, "truth"))
            found = {
                node: parse_object(text, f"truth of node {node}", TRUTH_LIMIT) for node, text in rows.items()
            }
    finally:
        connection.close()
    run = found.pop(RUN, {})
    return Truth(found, run)


def read_state(path: str | os.PathLike[str]) -> bytes | dict[str, Any] | None:
    """The session state in a map file. Raises: MapFileError, MapFileDamagedError."""
    target = Path(path)
    connection = open_map(target)
    try:
        with damage(target):
            return _read_state(connection)
    finally:
        connection.close()


def read_extensions(path: str | os.PathLike[str]) -> dict[tuple[str, str], Any]:
    """What third parties stored, by (owner, key). Raises: MapFileError, MapFileDamagedError."""
    target = Path(path)
    connection = open_map(target)
    try:
        with damage(target):
            rows = read_rows(connection, "ext")
            return {(owner, key): parse_json(text, f"extension {owner}/{key}") for owner, key, text in rows}
    finally:
        connection.close()


ENDINGS = ("-wal", "-shm", "-journal", ".part")


def _remove(path: Path, endings: tuple[str, ...] = ("", *ENDINGS)) -> None:
    for ending in endings:
        sibling(path, ending).unlink(missing_ok=True)


def _connect(path: Path, create: bool = True) -> sqlite3.Connection:
    name = f"file:{quote(str(path.absolute()))}?mode={'rwc' if create else 'rw'}"
    connection = sqlite3.connect(name, uri=True, isolation_level=None, check_same_thread=False, timeout=5.0)
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    connection.execute("PRAGMA journal_mode = DELETE" if create else "PRAGMA query_only = OFF")
    connection.execute("PRAGMA synchronous = EXTRA")
    return connection


def _begin_wal(connection: sqlite3.Connection) -> None:
    mode = connection.execute("PRAGMA journal_mode = WAL").fetchone()[0]
    if mode != "wal":
        raise sqlite3.OperationalError(f"no write-ahead log possible here (journal mode {mode})")
    connection.execute("PRAGMA synchronous = FULL")


def _drain(connection: sqlite3.Connection, path: Path) -> None:
    """Empties the write-ahead log: were a full one left beside the sealed file, SQLite would replay it."""
    busy = connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]
    if busy:
        raise sqlite3.OperationalError(f"somebody is still reading {path.name}")


def _put_state(writer: RowWriter, state: State) -> None:
    if state is None:
        return
    if isinstance(state, bytes):
        codec, data = "bytes", state
    else:
        codec, data = "json", dump_json(dict(state), "the session's state", STATE_LIMIT).encode()
    if len(data) > STATE_LIMIT:
        raise MapError(f"a session state of {len(data)} bytes: at most {STATE_LIMIT}")
    writer.put("session", (0, codec, data))


def _read_state(connection: sqlite3.Connection) -> bytes | dict[str, Any] | None:
    rows = read_rows(connection, "session")
    if not rows:
        return None
    _, codec, data = rows[0]
    if len(rows) > 1 or codec not in ("bytes", "json"):
        raise MapFileDamagedError("the session's state is not one row of bytes or json")
    return (
        bytes(data) if codec == "bytes" else parse_object(data.decode(), "the session's state", STATE_LIMIT)
    )
