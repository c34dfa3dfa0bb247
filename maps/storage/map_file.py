"""A map file that grows while the robot maps: what `append` has returned from is on disk."""

from __future__ import annotations

import contextlib
import os
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from urllib.parse import quote

from ...files.writing import atomic_path, check_target
from ..errors import MapError, MapFileDamagedError, MapFileError
from ..hybrid_map import HybridMap
from ..meta import MapMeta
from .graph import check_references, has_node, put_arc, put_meta, put_node, read_graph
from .locking import Lock
from .reader import check_all_digests, check_schema, check_version, damage, read_rows, reading
from .unpacking import StoredLocalMaps
from .values import dump_json, parse_json, parse_object
from .writer import RowWriter, draft, file_errors, remove_siblings, transaction, write_copy

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
        target, about = Path(path), MapMeta() if meta is None else meta
        with file_errors(target, "create", "--force overwrites it, --resume goes on with it"):
            target = check_target(target, replace=force)
            lock = Lock.acquire(target)
            try:
                with draft(target, force) as writer:
                    put_meta(writer, replace(about, current_node=None, arrival=None))  # no node is there yet
                file = cls(target, _connect(target), lock)
            except BaseException:
                lock.release()
                raise
        file.map.meta = about
        return file

    @classmethod
    def resume(cls, path: str | os.PathLike[str]) -> Self:
        """Goes on with a file, sealed or not: `map` and `state` are what was committed last.

        Raises: MapFileError, MapFileDamagedError, MapFileLockedError.
        """
        target = Path(path).resolve() if Path(path).is_symlink() else Path(path)
        if not target.is_file():
            raise MapFileError(f"{target}: there is no such file to resume")
        with file_errors(target, "resume"):
            lock = Lock.acquire(target)
        try:
            with file_errors(target, "resume"), damage(target):
                file = cls(target, _connect(target), lock)
                file._read()
        except BaseException:
            lock.release()
            raise
        return file

    def _read(self) -> None:
        connection = self._open()
        try:
            check_version(connection)
            check_schema(connection)
            check_all_digests(connection)
            self.map.meta, self.map.graph = read_graph(connection, StoredLocalMaps(self.path))
            self.state = _read_state(connection)
        except BaseException:
            connection.close()
            raise

    def append(
        self, hybrid: HybridMap, node: int, *, state: State = None, truth: Mapping[str, Any] | None = None
    ) -> None:
        """Commits a node of `hybrid`, its local map, its arcs from and to committed nodes, and the meta.

        state: the session's state as bytes or JSON object, so that a resumed run goes on exactly (None keeps
        the one there is). truth: JSON object for the node's row in the section that maps never read.
        When this returns the node is on disk.

        Raises: MapError, MapFileError; the file then keeps what it had.
        """
        edges = [*hybrid.graph.in_edges(node, keys=True), *hybrid.graph.out_edges(node, keys=True)]
        arcs = [key for key in edges if all(end == node or has_node(self._open(), end) for end in key[:2])]
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
        changed, ways = sorted(set(nodes)), sorted(set(arcs))
        with file_errors(self.path, "save"), transaction(self._open()) as writer:
            put_meta(writer, hybrid.meta)
            for node in changed:
                if node in hybrid.graph:
                    put_node(writer, hybrid.graph, node)
                else:
                    writer.delete("node", (node,))
                    writer.put_tensors(node, None)
            for key in ways:
                if hybrid.graph.has_edge(*key):
                    put_arc(writer, hybrid.graph, key)
                else:
                    writer.delete("arc", key)
            check_references(writer.connection, hybrid.meta, changed, ways)
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
                with atomic_path(self.path, replace=True) as part:
                    write_copy(self._connection, part)
                    _drain(self._connection, self.path)
                # Only now: without its log the unsealed file would not open, were this process killed here.
                self._connection.close()
                remove_siblings(self.path)
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
    with reading(Path(path)) as connection:
        found = {
            node: parse_object(text, f"truth of node {node}", TRUTH_LIMIT)
            for node, text in read_rows(connection, "truth")
        }
    run = found.pop(RUN, {})
    return Truth(found, run)


def read_state(path: str | os.PathLike[str]) -> bytes | dict[str, Any] | None:
    """The session state in a map file. Raises: MapFileError, MapFileDamagedError."""
    with reading(Path(path)) as connection:
        return _read_state(connection)


def read_extensions(path: str | os.PathLike[str]) -> dict[tuple[str, str], Any]:
    """What third parties stored, by (owner, key). Raises: MapFileError, MapFileDamagedError."""
    with reading(Path(path)) as connection:
        rows = read_rows(connection, "ext")
        return {(owner, key): parse_json(text, f"extension {owner}/{key}") for owner, key, text in rows}


def _connect(path: Path) -> sqlite3.Connection:
    """A connection to write through, in WAL mode."""
    name = f"file:{quote(str(path.absolute()))}?mode=rw"
    connection = sqlite3.connect(name, uri=True, isolation_level=None, check_same_thread=False, timeout=5.0)
    try:
        for setting in ("trusted_schema = OFF", "cell_size_check = ON", "synchronous = EXTRA"):
            connection.execute(f"PRAGMA {setting}")
        mode = connection.execute("PRAGMA journal_mode = WAL").fetchone()[0]
        if mode != "wal":
            raise sqlite3.OperationalError(f"no write-ahead log possible here (journal mode {mode})")
        connection.execute("PRAGMA synchronous = FULL")
    except BaseException:
        connection.close()
        raise
    return connection


def _drain(connection: sqlite3.Connection, path: Path) -> None:
    """Empties the write-ahead log: were a full one left beside the sealed file, SQLite would replay it."""
    if connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]:
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
