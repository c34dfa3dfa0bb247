"""Opens a map file that nobody vouches for, and reads its rows checked against their checksums."""

from __future__ import annotations

import sqlite3
import stat
import struct
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..errors import MapError, MapFileDamagedError, MapFileError, MapFileVersionError
from .locking import LOCK_SUFFIX, sibling
from .schema import APPLICATION_ID, CURRENT, Schema
from .values import row_hash, wrap_sum

MAX_FILE = 64 << 30
MAX_NODES = 1_000_000
MAX_ARCS_PER_NODE = 64
MAX_VALUE = 64 << 20
"""Longest text or blob, in bytes."""

DEADLINE = 60.0
"""Seconds one query may take before the file is refused: a guard against hangs, not a result."""


@contextmanager
def damage(path: Path) -> Iterator[None]:
    """Turns what SQLite raises while reading into one MapFileDamagedError, and prefixes the file's name."""
    try:
        yield
    except (MapFileDamagedError, MapFileVersionError) as error:
        text = str(error)
        raise type(error)(text if text.startswith(str(path)) else f"{path}: {text}") from None
    except MapFileError:
        raise
    except MapError as error:
        raise MapFileDamagedError(f"{path}: {error}") from None
    except sqlite3.OperationalError as error:
        if "readonly" in str(error):
            raise MapFileError(f"{path}: its writing was cut off; resume it first") from None
        if "locked" in str(error) or "unable to open" in str(error) or "disk I/O" in str(error):
            raise MapFileError(f"{path}: cannot read: {error}") from None
        raise MapFileDamagedError(f"{path}: damaged: {error}") from None
    except (sqlite3.Error, OverflowError, UnicodeError) as error:
        raise MapFileDamagedError(f"{path}: damaged: {error}") from None


def open_map(path: Path, schema: Schema = CURRENT) -> sqlite3.Connection:
    """A read-only connection to a map file whose header and schema are what they must be.

    A sealed file is opened as immutable; one that is being written is read through its journal.
    Raises: MapFileError, MapFileDamagedError.
    """
    # Closing a plain descriptor would drop the locks of a writer in this very process: ask SQLite instead.
    live = sibling(path, LOCK_SUFFIX).exists() and path.is_file()
    sealed = not live and check_header(path, schema)
    return _connect(path, "mode=ro&immutable=1" if sealed else "mode=ro", schema)


@contextmanager
def reading(path: Path, schema: Schema = CURRENT) -> Iterator[sqlite3.Connection]:
    """A connection as `open_map` gives it, for a block. Raises: MapFileError."""
    connection = open_map(path, schema)
    try:
        with damage(path):
            yield connection
    finally:
        connection.close()


def open_unchecked(path: Path) -> sqlite3.Connection:
    """A read-only connection for saving what can be saved: schema and settings are checked, sizes are not.

    Raises: MapFileError, MapFileDamagedError.
    """
    return _connect(path, "mode=ro" if sibling(path, "-wal").exists() else "mode=ro&immutable=1")


def _connect(path: Path, options: str, schema: Schema = CURRENT) -> sqlite3.Connection:
    with damage(path):
        connection = sqlite3.connect(
            f"file:{quote(str(path.absolute()))}?{options}",
            uri=True,
            isolation_level=None,
            check_same_thread=False,
            timeout=5.0,
        )
        try:
            harden(connection)
            check_version(connection, schema)
            check_schema(connection, schema)
        except BaseException:
            connection.close()
            raise
    return connection


def check_version(connection: sqlite3.Connection, schema: Schema = CURRENT) -> None:
    """Whether SQLite sees our application id and a version we know. Raises: MapFileError."""
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if application != APPLICATION_ID:
        raise MapFileDamagedError(f"not a map file (application id {application:#010x})")
    refuse_version(version, schema)


def refuse_version(version: int, schema: Schema) -> None:
    """Raises: MapFileVersionError for a file of another version than the schema's."""
    if version == schema.version:
        return
    told = f"format version {version}; this program reads version {schema.version}"
    if 0 < version < schema.version:
        raise MapFileVersionError(f"{told}: `tolman validate FILE --recover OUT` brings it up to date")
    raise MapFileVersionError(f"{told}: a newer tolman wrote it" if version > schema.version else told)


def version_of(path: Path) -> int:
    """The format version in a file's header, 0 when it has none; nothing else is checked."""
    try:
        with open(path, "rb") as file:
            header = file.read(64)
    except OSError:
        return 0
    return int.from_bytes(header[60:64], "big")


def check_header(path: Path, schema: Schema = CURRENT) -> bool:
    """Whether the file is sealed; checks what can be seen without SQLite. Raises: MapFileError."""
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            raise MapFileError(f"{path}: not a regular file")
        with open(path, "rb") as file:
            header = file.read(100)
    except OSError as error:
        raise MapFileError(f"{path}: cannot read: {error.strerror}") from None
    if about.st_size > MAX_FILE:
        raise MapFileError(f"{path}: {about.st_size} bytes: at most {MAX_FILE}")
    if len(header) < 100 or header[:16] != b"SQLite format 3\0":
        raise MapFileDamagedError(f"{path}: not a map file (no SQLite header)")
    application, version = struct.unpack(">I", header[68:72])[0], struct.unpack(">I", header[60:64])[0]
    if application != APPLICATION_ID:
        raise MapFileDamagedError(f"{path}: not a map file (application id {application:#010x})")
    try:
        refuse_version(version, schema)
    except MapFileError as error:
        raise type(error)(f"{path}: {error}") from None
    page_size = struct.unpack(">H", header[16:18])[0]
    page_size = 65536 if page_size == 1 else page_size
    pages = struct.unpack(">I", header[28:32])[0]
    sealed = header[18:20] == b"\x01\x01"
    if sealed and pages * page_size != about.st_size:
        raise MapFileDamagedError(
            f"{path}: {about.st_size} bytes where its header says {pages * page_size}: cut off?"
        )
    if not sealed and header[18:20] != b"\x02\x02":
        raise MapFileDamagedError(f"{path}: damaged: unknown file format in its header")
    if not sealed and not sibling(path, "-wal").exists():
        raise MapFileError(
            f"{path}: never sealed and its -wal file is not beside it, so nodes may be missing;"
            " copy both files, or recover what is there with `tolman validate --recover`"
        )
    if sealed and sibling(path, "-journal").exists():
        raise MapFileError(f"{path}: a -journal lies beside it: its writing was cut off; resume it first")
    return sealed


def harden(connection: sqlite3.Connection) -> None:
    """Settings under which a hostile file can do no harm."""
    for setting in ("trusted_schema = OFF", "cell_size_check = ON", "mmap_size = 0", "query_only = ON"):
        connection.execute(f"PRAGMA {setting}")
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_VALUE)
    connection.setlimit(sqlite3.SQLITE_LIMIT_SQL_LENGTH, 10_000)
    connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 0)
    end = time.monotonic() + DEADLINE
    connection.set_progress_handler(lambda: time.monotonic() > end, 100_000)


def check_schema(connection: sqlite3.Connection, schema: Schema = CURRENT) -> None:
    """Compares the schema with the version's, before any row is read. Raises: MapFileDamagedError."""
    expected = {("table", name, name, sql) for name, sql in schema.tables.items()}
    found = connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_master LIMIT 100").fetchall()
    if len(found) != len(expected) or set(found) != expected:
        raise MapFileDamagedError("its tables are not those of a map file of its version")


def read_rows(connection: sqlite3.Connection, table: str, schema: Schema = CURRENT) -> list[tuple[Any, ...]]:
    """All rows of a digested table in key order, without their hashes, every one verified.

    Raises: MapFileDamagedError.
    """
    known = connection.execute("SELECT rows, total FROM digest WHERE name = ?", (table,)).fetchone()
    if known is None or not fits(known, ((int,), (int,))):
        raise MapFileDamagedError(f"no digest of table {table}")
    rows, total, types = [], 0, schema.types[table]
    columns = ", ".join(schema.columns[table])
    for row in connection.execute(f"SELECT {columns}, hash FROM {table}"):
        if not fits(row, types):
            raise MapFileDamagedError(f"table {table}, row {row[0]!r:.40}: a value of a wrong type")
        if row_hash(table, row[:-1]) != row[-1]:
            raise MapFileDamagedError(f"table {table}, row {row[0]!r:.40}: checksum does not match")
        rows.append(row[:-1])
        total += row[-1]
        if len(rows) > known[0]:
            break
    if len(rows) != known[0] or wrap_sum(total) != known[1]:
        raise MapFileDamagedError(
            f"table {table}: its rows are not the {known[0]} that its digest was made of"
        )
    return rows


def fits(row: Sequence[object], types: Sequence[tuple[type, ...]]) -> bool:
    """Whether values are of the types that their columns hold: STRICT tables can be talked out of it."""
    return all(type(value) in allowed for value, allowed in zip(row, types, strict=True))


def check_all_digests(connection: sqlite3.Connection, schema: Schema = CURRENT) -> None:
    """Verifies every digested table. Raises: MapFileDamagedError."""
    for table in schema.columns:
        read_rows(connection, table, schema)


def read_tensors(connection: sqlite3.Connection, node: int) -> bytes:
    """The bytes of a node's local map. Raises: MapFileDamagedError, sqlite3.Error."""
    found = connection.execute("SELECT data FROM tensors WHERE node = ?", (node,)).fetchone()
    if found is None or not isinstance(found[0], bytes):
        raise MapFileDamagedError(f"node {node}: its local map is missing")
    return found[0]
