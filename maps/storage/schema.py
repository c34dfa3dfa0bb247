"""The SQL of map files by version. docs/format.md explains it; once released, a version never changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

APPLICATION_ID = 0x746C6D6E
"""`tlmn`: bytes 68 to 71 of the file."""

PAGE_SIZE = 16384


@dataclass(frozen=True, slots=True)
class Schema:
    """The tables of one version of the format.

    version: `PRAGMA user_version`, bytes 60 to 63 of the file. tables: table name -> the exact text that must
    stand in the file's schema. columns: of the digested tables, those that a row's hash covers, in that
    order; the hash column itself comes last. keys: how many of the first columns are the primary key.
    """

    version: int
    tables: Mapping[str, str]
    columns: Mapping[str, tuple[str, ...]]
    keys: Mapping[str, int]

    @property
    def digested(self) -> tuple[str, ...]:
        """Tables whose row count and wrapped sum of row hashes stand in `digest`."""
        return tuple(self.columns)

    def key(self, table: str) -> tuple[str, ...]:
        """The primary key's columns."""
        return self.columns[table][: self.keys[table]]


_TABLES_1 = {
    "meta": "CREATE TABLE meta (key TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL, hash INTEGER NOT NULL)"
    " STRICT, WITHOUT ROWID",
    "node": "CREATE TABLE node (id INTEGER NOT NULL PRIMARY KEY, name TEXT NOT NULL, corner TEXT NOT NULL,"
    " turn REAL NOT NULL, entry_heading REAL NOT NULL, notes TEXT NOT NULL, local_map TEXT,"
    " hash INTEGER NOT NULL) STRICT",
    "arc": 'CREATE TABLE arc (start INTEGER NOT NULL, "end" INTEGER NOT NULL, kind TEXT NOT NULL,'
    " side TEXT NOT NULL, distance REAL NOT NULL, variance REAL NOT NULL, traversals INTEGER NOT NULL,"
    ' blocked INTEGER NOT NULL, notes TEXT NOT NULL, hash INTEGER NOT NULL, PRIMARY KEY (start, "end", kind))'
    " STRICT, WITHOUT ROWID",
    "tensors": "CREATE TABLE tensors (node INTEGER NOT NULL PRIMARY KEY, data BLOB NOT NULL) STRICT",
    "session": "CREATE TABLE session (id INTEGER NOT NULL PRIMARY KEY, codec TEXT NOT NULL,"
    " state BLOB NOT NULL, hash INTEGER NOT NULL) STRICT",
    "truth": "CREATE TABLE truth (node INTEGER NOT NULL PRIMARY KEY, data TEXT NOT NULL,"
    " hash INTEGER NOT NULL) STRICT",
    "ext": "CREATE TABLE ext (owner TEXT NOT NULL, key TEXT NOT NULL, value TEXT NOT NULL,"
    " hash INTEGER NOT NULL, PRIMARY KEY (owner, key)) STRICT, WITHOUT ROWID",
    "digest": "CREATE TABLE digest (name TEXT NOT NULL PRIMARY KEY, rows INTEGER NOT NULL,"
    " total INTEGER NOT NULL) STRICT, WITHOUT ROWID",
}

VERSION_1 = Schema(
    version=1,
    tables=_TABLES_1,
    columns={
        "meta": ("key", "value"),
        "node": ("id", "name", "corner", "turn", "entry_heading", "notes", "local_map"),
        "arc": ("start", '"end"', "kind", "side", "distance", "variance", "traversals", "blocked", "notes"),
        "session": ("id", "codec", "state"),
        "truth": ("node", "data"),
        "ext": ("owner", "key", "value"),
    },
    keys={"meta": 1, "node": 1, "arc": 3, "session": 1, "truth": 1, "ext": 2},
)

SCHEMAS = {schema.version: schema for schema in (VERSION_1,)}
"""Every version that there has been: what `migrating` can read."""

CURRENT = VERSION_1
"""The version that is written, and read without migration."""
