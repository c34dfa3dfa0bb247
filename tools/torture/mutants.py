"""Damages map files: bytes, rows, and hostile content under checksums that hold."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
from tolman.maps.storage.schema import CURRENT

from .crafted import replace_value

BYTES = ("truncate", "extend", "flip", "flip few", "overwrite", "zero", "swap pages", "header", "double page")
ROWS = ("swap values", "set value", "delete row", "copy tensor", "swap tensors", "flip tensor", "digest")
SQL = {
    "view": "CREATE VIEW meta AS WITH RECURSIVE t(key) AS (SELECT 1 UNION ALL SELECT key FROM t)"
    " SELECT key, key AS value, key AS hash FROM t",
    "check": "CREATE TABLE meta (key TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL,"
    " hash INTEGER NOT NULL, CHECK (length(hex(zeroblob(900000000))) > 0)) STRICT, WITHOUT ROWID",
}
"""What hostile files say their table `meta` is."""
CRAFTED = ("huge tensor", "huge lattice", "deep json", "infinite", "dangling", *SQL, "trigger", "blob")
MUTATIONS = BYTES * 3 + ROWS * 2 + CRAFTED


def mutate(source: Path, path: Path, name: str, rng: np.random.Generator) -> bool:
    """Writes a damaged copy; whether it was crafted with checksums that hold."""
    if name in BYTES:
        path.write_bytes(_bytes_mutant(source.read_bytes(), name, rng))
        return False
    path.write_bytes(source.read_bytes())
    connection = sqlite3.connect(path, isolation_level=None)
    try:
        connection.execute("PRAGMA writable_schema = ON")
        if name in ROWS:
            _row_mutant(connection, name, rng)
        else:
            _crafted_mutant(connection, name, rng)
    finally:
        connection.close()
    return name in CRAFTED


def _bytes_mutant(data: bytes, name: str, rng: np.random.Generator) -> bytes:
    mutant, size, page = bytearray(data), len(data), 16384
    place, length = int(rng.integers(size)), int(rng.integers(1, 5000))
    if name == "truncate":
        return bytes(mutant[:place])
    if name == "extend":
        return bytes(mutant) + rng.bytes(length)
    if name == "flip":
        mutant[place] ^= 1 << int(rng.integers(8))
    elif name == "flip few":
        for _ in range(int(rng.integers(2, 40))):
            mutant[int(rng.integers(size))] ^= 1 << int(rng.integers(8))
    elif name == "overwrite":
        mutant[place : place + length] = rng.bytes(min(length, size - place))
    elif name == "zero":
        mutant[place : place + length] = bytes(min(length, size - place))
    elif name == "header":
        mutant[int(rng.integers(16, 100))] = int(rng.integers(256))
    else:
        one, other = (int(n) * page for n in rng.integers(size // page, size=2))
        first, second = mutant[one : one + page], mutant[other : other + page]
        mutant[other : other + page] = first
        if name == "swap pages":
            mutant[one : one + page] = second
    return bytes(mutant)


def _row_mutant(connection: sqlite3.Connection, name: str, rng: np.random.Generator) -> None:
    table = ("node", "arc", "meta", "truth", "session")[int(rng.integers(5))]
    columns = CURRENT.columns[table][1:]
    column = columns[int(rng.integers(len(columns)))]
    number = int(rng.integers(4))
    if name == "swap values":
        table, column = ("node", "arc")[number % 2], ("turn", "distance")[number % 2]
        key = "id" if table == "node" else "start"
        connection.execute(f"UPDATE {table} SET {column} = {column} + 0.25 WHERE {key} % 2 = 0")
    elif name == "set value":
        values = (0, 7, -1.5, "x", b"\x00" * 8, None, 2**62)
        value = values[int(rng.integers(len(values)))]
        try:
            connection.execute(f"UPDATE {table} SET {column} = ?", (value,))
        except sqlite3.Error:
            connection.execute("UPDATE node SET turn = turn + 1 WHERE id = 0")
    elif name == "delete row":
        connection.execute(f"DELETE FROM {table} WHERE hash = (SELECT max(hash) FROM {table})")
    elif name == "copy tensor":
        connection.execute(
            "UPDATE tensors SET data = (SELECT data FROM tensors WHERE node = 0) WHERE node = 1"
        )
    elif name == "swap tensors":
        connection.execute("UPDATE tensors SET node = 100 WHERE node = 0")
        connection.execute("UPDATE tensors SET node = 0 WHERE node = 1")
    elif name == "flip tensor":
        data = bytearray(
            connection.execute("SELECT data FROM tensors WHERE node = ?", (number,)).fetchone()[0]
        )
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        connection.execute("UPDATE tensors SET data = ? WHERE node = ?", (bytes(data), number))
    else:
        connection.execute("UPDATE digest SET total = total + 1 WHERE name = 'node'")


def _crafted_mutant(connection: sqlite3.Connection, name: str, rng: np.random.Generator) -> None:
    """Hostile content under checksums that hold."""
    if name in ("huge tensor", "huge lattice"):
        manifest = json.loads(connection.execute("SELECT local_map FROM node WHERE id = 0").fetchone()[0])
        if name == "huge tensor":
            manifest["tensors"][0][2] = [[2**40, 2], [2**62, 2**62], [-1, -2], [10**30, 1]][
                int(rng.integers(4))
            ]
        else:
            manifest["metric"] = [[10**9, 10**9, "hexagonal"], [5, -5, "hexagonal"], [25, 1e300, "x"]][
                int(rng.integers(3))
            ]
        _reset(connection, "node", "local_map", json.dumps(manifest))
    elif name == "deep json":
        _reset(connection, "node", "notes", "[" * 2000 + "]" * 2000)
    elif name == "infinite":
        _reset(connection, "node", "turn", float("inf"))
    elif name == "dangling":
        _reset(connection, "arc", '"end"', 99)
    elif name == "blob":
        connection.execute("UPDATE tensors SET data = zeroblob(100000000) WHERE node = 0")
    elif name == "trigger":
        connection.execute("CREATE TRIGGER evil AFTER INSERT ON meta BEGIN DELETE FROM node; END")
    else:
        kind, root = ("view", "0") if name == "view" else ("table", "rootpage")
        connection.execute(
            f"UPDATE sqlite_master SET type = '{kind}', rootpage = {root}, sql = ? WHERE name = 'meta'",
            (SQL[name],),
        )


def _reset(connection: sqlite3.Connection, table: str, column: str, value: Any) -> None:
    """Changes one value of the first row."""
    columns = CURRENT.columns[table]
    row = connection.execute(f"SELECT {', '.join(columns)} FROM {table} LIMIT 1").fetchone()
    replace_value(connection, table, list(row), columns.index(column), value)
