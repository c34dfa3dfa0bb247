"""Writes rows into an open map database: checksums, digest, and sealing into its one canonical layout."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...files.messages import FileError
from ...files.writing import TargetExistsError, atomic_path, check_target
from ..errors import MapFileError, MapFileExistsError
from .locking import Lock, sibling
from .schema import APPLICATION_ID, CURRENT, PAGE_SIZE, Schema
from .values import Value, row_hash, wrap_sum

_SCHEMA_COOKIE = 40
"""Where the file's header has the 4-byte counter of schema changes."""


@contextmanager
def file_errors(path: Path, doing: str, hint: str = "force overwrites it") -> Iterator[None]:
    """Turns what SQLite, the system and the gate raise into one MapFileError that names file and deed."""
    try:
        yield
    except TargetExistsError:
        raise MapFileExistsError(f"{path} exists already; {hint}") from None
    except FileError as error:
        raise MapFileError(str(error)) from error
    except (sqlite3.Error, OSError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise MapFileError(f"{path}: cannot {doing}: {reason}; what was saved before is kept") from error


def _create_tables(connection: sqlite3.Connection, schema: Schema) -> None:
    """Makes an empty map of an empty database, in the caller's transaction."""
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {schema.version}")
    for statement in schema.tables.values():
        connection.execute(statement)
    connection.executemany(
        "INSERT INTO digest VALUES (?, 0, 0)", [(name,) for name in sorted(schema.columns)]
    )


class RowWriter:
    """Puts and deletes rows inside the caller's transaction and keeps the digest; `finish` before COMMIT."""

    def __init__(self, connection: sqlite3.Connection, schema: Schema = CURRENT) -> None:
        """Begins with an unchanged digest."""
        self.connection, self._schema = connection, schema
        self._changes: dict[str, tuple[int, int]] = {}

    def put(self, table: str, row: tuple[Value, ...]) -> bool:
        """Inserts a row, in the order of its columns, or replaces the one with its key; whether it had to.

        A row that is there already costs no write: most of what a commit puts has not changed.
        """
        clean = tuple(
            value + 0.0 if isinstance(value, float) else value for value in row
        )  # no -0.0: see format.md
        value, there = row_hash(table, clean), self._hash(table, clean[: self._schema.keys[table]])
        if value == there:
            return False
        marks = ", ".join("?" * (len(clean) + 1))
        self.connection.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", (*clean, value))
        self._change(table, int(there is None), value - (there or 0))
        return True

    def delete(self, table: str, key: tuple[Value, ...]) -> None:
        """Deletes the row with that key, if there is one."""
        there = self._hash(table, key)
        if there is not None:
            self.connection.execute(f"DELETE FROM {table} WHERE {self._where(table)}", key)
            self._change(table, -1, -there)

    def _hash(self, table: str, key: tuple[Value, ...]) -> int | None:
        query = f"SELECT hash FROM {table} WHERE {self._where(table)}"
        found = self.connection.execute(query, key).fetchone()
        return None if found is None else int(found[0])

    def _where(self, table: str) -> str:
        return " AND ".join(f"{column} = ?" for column in self._schema.key(table))

    def put_tensors(self, node: int, data: bytes | None) -> None:
        """Sets or, with None, removes the bytes of a node's local map."""
        if data is None:
            self.connection.execute("DELETE FROM tensors WHERE node = ?", (node,))
        else:
            self.connection.execute("INSERT OR REPLACE INTO tensors VALUES (?, ?)", (node, data))

    def finish(self) -> None:
        """Writes the changed digest."""
        for table, (rows, total) in sorted(self._changes.items()):
            row = self.connection.execute(
                "SELECT rows, total FROM digest WHERE name = ?", (table,)
            ).fetchone()
            self.connection.execute(
                "UPDATE digest SET rows = ?, total = ? WHERE name = ?",
                (row[0] + rows, wrap_sum(row[1] + total), table),
            )
        self._changes.clear()

    def _change(self, table: str, rows: int, total: int) -> None:
        known = self._changes.get(table, (0, 0))
        self._changes[table] = (known[0] + rows, known[1] + total)


@contextmanager
def transaction(connection: sqlite3.Connection, schema: Schema = CURRENT) -> Iterator[RowWriter]:
    """One transaction: committed when the block ends well, rolled back when it raises."""
    connection.execute("BEGIN IMMEDIATE")
    writer = RowWriter(connection, schema)
    try:
        yield writer
        writer.finish()
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def write_copy(connection: sqlite3.Connection, part: Path) -> None:
    """Writes the database to an empty file: same content, same bytes."""
    connection.execute("VACUUM INTO ?", (str(part),))
    with open(part, "rb+") as file:
        file.seek(_SCHEMA_COOKIE)
        file.write(b"\0\0\0\1")  # VACUUM counts it up each time: the one byte that is not content


@contextmanager
def drafting(target: Path, force: bool = False, schema: Schema = CURRENT) -> Iterator[RowWriter]:
    """Writes a whole new sealed file through the writer it yields; it appears at the end or not at all.

    Raises: MapFileExistsError without force, MapFileError.
    """
    with file_errors(target, "write"):
        target = check_target(target, replace=force)
        with Lock.held(target), draft(target, force, schema) as writer:
            yield writer


@contextmanager
def draft(target: Path, replace: bool, schema: Schema = CURRENT) -> Iterator[RowWriter]:
    """As `drafting`, for who holds the lock of `target` already."""
    with (
        atomic_path(target, replace=replace) as part,
        tempfile.TemporaryDirectory(prefix=".tolman-", dir=target.parent) as folder,
    ):
        connection = sqlite3.connect(Path(folder) / "draft", isolation_level=None)
        try:
            for setting in (
                f"page_size = {PAGE_SIZE}",
                "encoding = 'UTF-8'",
                "journal_mode = OFF",
                "synchronous = OFF",
            ):
                connection.execute(f"PRAGMA {setting}")
            with transaction(connection, schema) as writer:
                _create_tables(connection, schema)
                yield writer
            write_copy(connection, part)
        finally:
            connection.close()
        remove_siblings(target)


ENDINGS = ("-wal", "-shm", "-journal")


def remove_siblings(path: Path) -> None:
    """Removes what SQLite leaves beside a database that is no longer open."""
    for ending in ENDINGS:
        sibling(path, ending).unlink(missing_ok=True)
