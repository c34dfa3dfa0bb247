"""Writes rows into an open map database: checksums, digest, and sealing into its one canonical layout."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import MapFileError
from .records import Value, row_hash, wrap_sum
from .schema import APPLICATION_ID, CURRENT, PAGE_SIZE, Schema

_SCHEMA_COOKIE = 40
"""Where the file's header has the 4-byte counter of schema changes."""


@contextmanager
def file_errors(path: Path, doing: str) -> Iterator[None]:
    """Turns what SQLite and the system raise into one MapFileError that names the file and the deed."""
    try:
        yield
    except (sqlite3.Error, OSError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise MapFileError(f"{path}: cannot {doing}: {reason}; what was saved before is kept") from error


def create_tables(connection: sqlite3.Connection, schema: Schema = CURRENT) -> None:
    """Makes an empty map of an empty database, in one transaction, with a rollback journal."""
    connection.execute(f"PRAGMA page_size = {PAGE_SIZE}")
    connection.execute("PRAGMA encoding = 'UTF-8'")
    connection.execute("BEGIN IMMEDIATE")
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {schema.version}")
    for statement in schema.tables.values():
        connection.execute(statement)
    connection.executemany(
        "INSERT INTO digest VALUES (?, 0, 0)", [(name,) for name in sorted(schema.digested)]
    )
    connection.execute("COMMIT")


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


def write_copy(connection: sqlite3.Connection, path: Path) -> Path:
    """Writes the database durably to a new file beside `path`: same content, same bytes. Returns its name."""
    part = sibling(path, ".part")
    part.unlink(missing_ok=True)
    try:
        connection.execute("VACUUM INTO ?", (str(part),))
        with open(part, "rb+") as file:
            file.seek(_SCHEMA_COOKIE)
            file.write(b"\0\0\0\1")  # VACUUM counts it up each time: the one byte that is not content
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return part


def replace_file(part: Path, path: Path) -> None:
    """Puts a finished file in the place of another, at once and durably."""
    os.replace(part, path)
    sync_folder(path)


def sibling(path: Path, suffix: str) -> Path:
    """The file beside `path` with that ending added to its name."""
    return path.with_name(path.name + suffix)


def sync_folder(path: Path) -> None:
    """Makes the names in the folder of `path` durable, where the system can."""
    if os.name == "posix":
        descriptor = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
