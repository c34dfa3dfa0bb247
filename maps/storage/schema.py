"""The SQL of map files by version. docs/format.md explains it; once released, a version never changes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ..fields import ARC, NODE

APPLICATION_ID = 0x746C6D6E
"""`tlmn`: bytes 68 to 71 of the file."""

PAGE_SIZE = 16384

_COLUMN = re.compile(r'("?[a-z_]+"?) (INTEGER|REAL|TEXT|BLOB)( NOT NULL)?')
_STORED = {"INTEGER": int, "REAL": float, "TEXT": str, "BLOB": bytes}


@dataclass(frozen=True)
class Schema:
    """The tables of one version of the format.

    version: `PRAGMA user_version`, bytes 60 to 63 of the file. tables: table name -> the exact text that must
    stand in the file's schema. Tables with a hash, the last column of theirs, are digested: their row count
    and the wrapped sum of their hashes stand in `digest`.
    """

    version: int
    tables: Mapping[str, str]

    @cached_property
    def columns(self) -> dict[str, tuple[str, ...]]:
        """Of the digested tables, the columns that a row's hash covers, in that order."""
        return {table: tuple(name for name, *_ in found[:-1]) for table, found in self._parsed.items()}

    @cached_property
    def types(self) -> dict[str, tuple[tuple[type, ...], ...]]:
        """Of the digested tables, what Python may get for each column and the hash."""
        return {
            table: tuple((_STORED[kind],) if full else (_STORED[kind], type(None)) for _, kind, full in found)
            for table, found in self._parsed.items()
        }

    @cached_property
    def _parsed(self) -> dict[str, list[tuple[str, str, str]]]:
        found = {table: _COLUMN.findall(sql) for table, sql in self.tables.items()}
        return {table: columns for table, columns in found.items() if columns[-1][0] == "hash"}

    @cached_property
    def keys(self) -> dict[str, int]:
        """How many of a digested table's first columns are its primary key."""
        several = {table: re.search(r"PRIMARY KEY \((.*?)\)", self.tables[table]) for table in self.columns}
        return {table: found.group(1).count(",") + 1 if found else 1 for table, found in several.items()}

    def key(self, table: str) -> tuple[str, ...]:
        """The primary key's columns."""
        return self.columns[table][: self.keys[table]]


_HASH = "hash INTEGER NOT NULL"
_NODE_COLUMNS, _ARC_COLUMNS = (record.columns(version=1) for record in (NODE, ARC))

VERSION_1 = Schema(
    version=1,
    tables={
        "meta": f"CREATE TABLE meta (key TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL, {_HASH})"
        " STRICT, WITHOUT ROWID",
        "node": f"CREATE TABLE node ({_NODE_COLUMNS[0].sql} PRIMARY KEY,"
        f" {', '.join(each.sql for each in _NODE_COLUMNS[1:])}, local_map TEXT, {_HASH}) STRICT",
        "arc": f"CREATE TABLE arc ({', '.join(each.sql for each in _ARC_COLUMNS)}, {_HASH},"
        ' PRIMARY KEY (start, "end", kind)) STRICT, WITHOUT ROWID',
        "tensors": "CREATE TABLE tensors (node INTEGER NOT NULL PRIMARY KEY, data BLOB NOT NULL) STRICT",
        "session": "CREATE TABLE session (id INTEGER NOT NULL PRIMARY KEY, codec TEXT NOT NULL,"
        f" state BLOB NOT NULL, {_HASH}) STRICT",
        "truth": "CREATE TABLE truth (node INTEGER NOT NULL PRIMARY KEY, data TEXT NOT NULL,"
        f" {_HASH}) STRICT",
        "ext": f"CREATE TABLE ext (owner TEXT NOT NULL, key TEXT NOT NULL, value TEXT NOT NULL, {_HASH},"
        " PRIMARY KEY (owner, key)) STRICT, WITHOUT ROWID",
        "digest": "CREATE TABLE digest (name TEXT NOT NULL PRIMARY KEY, rows INTEGER NOT NULL,"
        " total INTEGER NOT NULL) STRICT, WITHOUT ROWID",
    },
)

SCHEMAS = {schema.version: schema for schema in (VERSION_1,)}
"""Every version that there has been: what `migration` can read."""

CURRENT = VERSION_1
"""The version that is written, and read without migration."""
