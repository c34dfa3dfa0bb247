"""The SQL of a map file, version 1. docs/format.md explains it; once released, a version never changes."""

from __future__ import annotations

APPLICATION_ID = 0x746C6D6E
"""`tlmn`: bytes 68 to 71 of the file."""

FORMAT_VERSION = 1
"""`PRAGMA user_version`: bytes 60 to 63 of the file."""

PAGE_SIZE = 16384

TABLES = {
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
"""Table name -> the exact text that must stand in the file's schema."""

DIGESTED = ("meta", "node", "arc", "session", "truth", "ext")
"""Tables whose row count and wrapped sum of row hashes stand in `digest`."""

KEYS = {
    "meta": ("key",),
    "node": ("id",),
    "arc": ("start", '"end"', "kind"),
    "session": ("id",),
    "truth": ("node",),
    "ext": ("owner", "key"),
}
"""Primary key columns of the digested tables."""

COLUMNS = {
    "meta": ("key", "value"),
    "node": ("id", "name", "corner", "turn", "entry_heading", "notes", "local_map"),
    "arc": ("start", '"end"', "kind", "side", "distance", "variance", "traversals", "blocked", "notes"),
    "session": ("id", "codec", "state"),
    "truth": ("node", "data"),
    "ext": ("owner", "key", "value"),
}
"""Columns in the order in which a row's hash covers them; the hash column itself comes last."""
