"""Brings map files of older format versions up to date: one pure function from each version to the next.

A new version of the format adds its schema to `schema.SCHEMAS`, a `Step` to `STEPS`, and a golden file of the
old version to the tests. Nothing else reads old versions: they are refused with a line that names this way.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import MapFileVersionError
from .locking import LOCK_SUFFIX, sibling
from .packing import check_manifest
from .reader import check_all_digests, read_rows, read_tensors, reading, version_of
from .schema import CURRENT, SCHEMAS, Schema
from .values import Value
from .writer import drafting

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
    """Writes a map file of an older version as one of the current version, sealed; `path` stays as it is.

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
    with reading(target, schema) as connection:
        check_all_digests(connection, schema)
        rows = {table: read_rows(connection, table, schema) for table in schema.columns}
        for step in steps:
            rows = step.rows(rows)
        with drafting(Path(output), force, known.current) as writer:
            for table in known.current.columns:
                if table != "node":
                    for row in rows[table]:
                        writer.put(table, row)
            at = known.current.columns["node"].index("local_map")
            maps = 0
            for row in rows["node"]:
                manifest = row[at]
                if isinstance(manifest, str):
                    manifest, data = _local_map(connection, int(row[0] or 0), manifest, steps)
                    writer.put_tensors(int(row[0] or 0), data)
                    maps += 1
                writer.put("node", (*row[:at], manifest, *row[at + 1 :]))
    return Migrated(schema.version, len(rows["node"]), len(rows["arc"]), maps)


def _local_map(
    connection: sqlite3.Connection, node: int, manifest: str, steps: list[Step]
) -> tuple[str, bytes]:
    """Manifest and bytes of a node's local map in the newest version, verified before the first step."""
    data = read_tensors(connection, node)
    check_manifest(manifest, data, f"node {node}")
    for step in steps:
        manifest, data = step.local_map(manifest, data)
    return manifest, data
