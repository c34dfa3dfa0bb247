"""Map files of somebody who knows the format: hostile values of any type, under checksums that hold."""

from __future__ import annotations

import hashlib
import json
import math
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
from tolman.maps.storage.schema import CURRENT
from tolman.maps.storage.values import row_hash, wrap_sum

INTEGERS = (0, 1, -1, 7, 2**31, 2**53, 2**62, -(2**63))
FLOATS = (0.5, -1.5, 1e9, 1e308, -1e308, 5e-324, math.inf, -math.inf)
LABELS = ("", "x", "5", "right", "foray", "concave")
WORDS = (*LABELS, "\0", "\x1b[31m\u202e", "a\nb", "n0", "9" * 4000, "x" * 5000)
JSON_VALUES = ("{}", "[]", "null", "NaN", "1e999", "[" * 2000, '{"a":1,"a":2}')
PLACES = ('{"place_m":[1e308,1e308]}', '{"pose":[]}', '{"place_m":["x"]}', '{"tolman:x":[]}', '{"place_m":5}')
MORE_JSON = ('{"pose":"x","track":[[1]]}', '"x"', "-0", "true")
BYTES = (b"", b"\xff" * 8, bytes(1000))
VALUES = (*INTEGERS, *FLOATS, *WORDS, *JSON_VALUES, *PLACES, *MORE_JSON, *BYTES, None)
NESTED: tuple[Any, ...] = ([], {}, [[1, 2]], [10**30], {"a": {"b": []}})
LEAVES: tuple[Any, ...] = (*INTEGERS, *FLOATS[:5], *WORDS, True, None, *NESTED)
JSON_COLUMNS = {"meta": ["value"], "node": ["notes", "local_map"], "arc": ["notes"], "truth": ["data"]}
TABLES = (
    *CURRENT.columns,
    *("node", "arc", "node", "arc", "local map", "local map", "tensors", "digest", "text"),
)


def craft(source: Path, path: Path, rng: np.random.Generator) -> str:
    """Writes a copy with one to three hostile values whose checksums hold; what was changed, in words."""
    path.write_bytes(source.read_bytes())
    connection = sqlite3.connect(path, isolation_level=None)
    _set_strict(connection, False)
    connection.close()
    connection = sqlite3.connect(path, isolation_level=None)  # parses the schema again: no types are kept now
    changed = []
    try:
        for _ in range(int(rng.integers(1, 4))):
            table = TABLES[int(rng.integers(len(TABLES)))]
            try:
                changed.append(_change(connection, table, rng))
            except (sqlite3.IntegrityError, sqlite3.OperationalError):  # two of a key; a text it cannot read
                changed.append("nothing")
        _set_strict(connection, True)
    finally:
        connection.close()
    return ", ".join(changed)


def _set_strict(connection: sqlite3.Connection, strict: bool) -> None:
    connection.execute("PRAGMA writable_schema = ON")
    for table, sql in CURRENT.tables.items():
        loose = sql.replace(" STRICT, WITHOUT", " WITHOUT").replace(" STRICT", "").replace(" NOT NULL", "")
        connection.execute(
            "UPDATE sqlite_master SET sql = ? WHERE name = ?", (sql if strict else loose, table)
        )
    connection.execute("PRAGMA writable_schema = OFF")


def _change(connection: sqlite3.Connection, table: str, rng: np.random.Generator) -> str:
    value = VALUES[int(rng.integers(len(VALUES)))]
    if table == "digest":
        column = ("rows", "total", "name")[int(rng.integers(3))]
        connection.execute(f"UPDATE digest SET {column} = ? WHERE name = 'arc'", (value,))
        return f"digest.{column}"
    if table == "tensors":
        connection.execute("UPDATE tensors SET data = ? WHERE node = 1", (value,))
        return "tensors.data"
    if table == "text":
        connection.execute("UPDATE node SET name = CAST(x'ff41' AS TEXT) WHERE id = 2")
        return "text that is not UTF-8"
    if table == "local map":
        return _change_local_map(connection, rng)
    columns = CURRENT.columns[table]
    rows = connection.execute(f"SELECT {', '.join(columns)} FROM {table}").fetchall()
    if not rows:
        return "nothing"
    row = list(rows[int(rng.integers(len(rows)))])
    at = int(rng.integers(len(columns)))
    if columns[at] in JSON_COLUMNS.get(table, ()) and rng.random() < 0.6:
        value = _hostile_json(row[at], rng)
    replace_value(connection, table, row, at, value)
    return f"{table}.{columns[at]}"


def replace_value(connection: sqlite3.Connection, table: str, row: list[Any], at: int, value: Any) -> None:
    """Changes one value of a row, and the row's checksum and the digest with it."""
    columns, count = CURRENT.columns[table], CURRENT.keys[table]
    where = " AND ".join(f"{column} IS ?" for column in columns[:count])
    ((old,),) = connection.execute(f"SELECT hash FROM {table} WHERE {where}", row[:count]).fetchall()
    new = row_hash(table, (*row[:at], value, *row[at + 1 :]))
    connection.execute(
        f"UPDATE {table} SET {columns[at]} = ?, hash = ? WHERE {where}", (value, new, *row[:count])
    )
    ((total,),) = connection.execute("SELECT max(total) FROM digest WHERE name = ?", (table,)).fetchall()
    if isinstance(total, int) and isinstance(old, int):
        connection.execute("UPDATE digest SET total = ? WHERE name = ?", (wrap_sum(total + new - old), table))


def _change_local_map(connection: sqlite3.Connection, rng: np.random.Generator) -> str:
    """Changes the bytes of a local map, or what its manifest says of them, so that all hashes hold."""
    node = int(rng.integers(3))
    columns = ", ".join(CURRENT.columns["node"])
    row = connection.execute(f"SELECT {columns} FROM node WHERE id IS ?", (node,)).fetchone()
    found = connection.execute("SELECT data FROM tensors WHERE node IS ?", (node,)).fetchone()
    if row is None or found is None or not isinstance(found[0], bytes) or not isinstance(row[-1], str):
        return "nothing"
    data = bytearray(found[0])
    manifest = json.loads(row[-1]) if row[-1].startswith('{"b') else {}
    for _ in range(int(rng.integers(1, 4))):
        place = 8 * int(rng.integers(max(1, len(data) // 8)))
        number = (math.nan, math.inf, 1e300, -1.0, 5e-324)[int(rng.integers(5))]
        part = rng.bytes(8) if rng.random() < 0.3 else np.float64(number).tobytes()
        data[place : place + 8] = part
    if rng.random() < 0.5 and manifest:
        manifest = json.loads(_hostile_json(json.dumps(manifest), rng, whole=False))
    if isinstance(manifest, dict):
        manifest.update(bytes=len(data), hash=hashlib.blake2b(data, digest_size=16).hexdigest())
    connection.execute("UPDATE tensors SET data = ? WHERE node = ?", (bytes(data), node))
    text = json.dumps(manifest, sort_keys=True, separators=(",", ":"))
    replace_value(connection, "node", list(row), len(row) - 1, text)
    return "a local map"


def _hostile_json(text: Any, rng: np.random.Generator, whole: bool = True) -> str:
    """The JSON text with one of its values replaced, or a key added."""
    try:
        tree = json.loads(text)
    except (TypeError, ValueError):
        return "{}"
    leaf = LEAVES[int(rng.integers(len(LEAVES)))]
    node = tree
    for _ in range(5):
        keys: list[Any] = (
            list(node) if isinstance(node, dict) else list(range(len(node) if isinstance(node, list) else 0))
        )
        if not keys:
            break
        key = keys[int(rng.integers(len(keys)))]
        if not isinstance(node[key], dict | list) or not node[key] or rng.random() < 0.3:
            node[key] = leaf
            return json.dumps(tree)
        node = node[key]
    if isinstance(node, dict):
        node["tolman:x" if rng.random() < 0.5 else "place_m"] = leaf
    return json.dumps(leaf if whole and node is tree and not isinstance(tree, dict) else tree)
