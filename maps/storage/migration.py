"""Brings map files of older format versions up to date: one pure function from each version to the next.

A new version of the format adds its schema to `schema.SCHEMAS`, a `Step` to `STEPS`, and a golden file of the
old version to the tests. Nothing else reads old versions: they are refused with a line that names this way.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import MapFileDamagedError, MapFileVersionError
from .locking import LOCK_SUFFIX
from .reader import check_all_digests, damage, open_map, read_rows, version_of
from .records import Value, parse_object
from .schema import CURRENT, SCHEMAS, Schema
from .store import drafting
from .writer import sibling

Row = tuple[Value, ...]
Rows = dict[str, list[Row]]
"""Of each digested table all rows, without their hashes, in the order of the schema's columns."""


def _same_rows(rows: Rows) -> Rows:
    return rows


def _same_local_map(manifest: str, data: bytes) -> tuple[str, bytes]:
    return manifest, data


@dataclass(frozen=True, slots=True)
class Step:
    """From one version to the next. Both functions are pure.

    rows: the digested tables, all at once. local_map: manifest and bytes of one local map at a time, so that
    a map larger than the memory can be brought over; its manifest must tell length and hash of the bytes.
    """

    rows: Callable[[Rows], Rows] = _same_rows
    local_map: Callable[[str, bytes], tuple[str, bytes]] = _same_local_map


STEPS: dict[int, Step] = {}
"""Version -> the step from it to the next. Empty as long as version 1 is the only one."""


@dataclass(frozen=True, slots=True)
class Formats:
    """The versions there have been, the steps between them, and the one that is written."""

    schemas: Mapping[int, Schema] = field(default_factory=lambda: SCHEMAS)
    steps: Mapping[int, Step] = field(default_factory=lambda: STEPS)
    current: Schema = CURRENT

    def older(self, path: Path) -> Schema | None:
        """The schema of a file of a known older version; None for any other, and one being written."""
        if sibling(path, LOCK_SUFFIX).exists():
            return None
        version = version_of(path)
        return self.schemas.get(version) if version < self.current.version else None


FORMATS = Formats()


@dataclass(frozen=True, slots=True)
class Migrated:
    """What was brought over. version: the one it came from."""

    version: int
    nodes: int
    arcs: int
    local_maps: int


def migrate(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    force: bool = False,
    formats: Formats | None = None,
) -> Migrated:
    """Writes a map file of an older version anew in the current one, sealed; `path` stays as it is.

    Everything is verified while it is read: a damaged file is refused, and `output` not written.

    Raises: MapFileVersionError when the file is of no known older version, MapFileDamagedError,
    MapFileExistsError, MapFileError.
    """
    known = FORMATS if formats is None else formats
    target = Path(path)
    schema = known.older(target)
    if schema is None:
        raise MapFileVersionError(f"{target}: not a sealed map file of an older version that can be migrated")
    steps = [known.steps[version] for version in range(schema.version, known.current.version)]
    connection = open_map(target, schema)
    try:
        rows = _read(connection, target, schema)
        for step in steps:
            rows = step.rows(rows)
        with drafting(Path(output), force, known.current) as writer:
            for table in known.current.digested:
                if table != "node":
                    for row in rows[table]:
                        writer.put(table, row)
            at = known.current.columns["node"].index("local_map")
            maps = 0
            for row in rows["node"]:
                manifest = row[at]
                if isinstance(manifest, str):
                    manifest, data = _local_map(connection, target, row[0], manifest, steps)
                    writer.put_tensors(int(row[0] or 0), data)
                    maps += 1
                writer.put("node", (*row[:at], manifest, *row[at + 1 :]))
    finally:
        connection.close()
    return Migrated(schema.version, len(rows["node"]), len(rows["arc"]), maps)


def _read(connection: sqlite3.Connection, path: Path, schema: Schema) -> Rows:
    with damage(path):
        check_all_digests(connection, schema)
        return {table: read_rows(connection, table, schema) for table in schema.digested}


def _local_map(
    connection: sqlite3.Connection, path: Path, node: Value, manifest: str, steps: list[Step]
) -> tuple[str, bytes]:
    """Manifest and bytes of a node's local map in the newest version, verified before the first step."""
    where = f"node {node!r}"
    with damage(path):
        found = connection.execute("SELECT data FROM tensors WHERE node = ?", (node,)).fetchone()
        about = parse_object(manifest, f"{where}: the local map's manifest")
        if found is None or not isinstance(found[0], bytes):
            raise MapFileDamagedError(f"{where}: its local map is missing")
        whole = hashlib.blake2b(found[0], digest_size=16).hexdigest()
        if (len(found[0]), whole) != (about.get("bytes"), about.get("hash")):
            raise MapFileDamagedError(f"{where}: the local map's bytes do not match their checksum")
    data: bytes = found[0]
    for step in steps:
        manifest, data = step.local_map(manifest, data)
    return manifest, data
