"""Local maps from their manifest and bytes, read from the file when they are first used."""

from __future__ import annotations

import math
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MapFileDamagedError
from ..local.content import LocalMapContent
from ..local.local_map import LocalMap
from ..som.lattice import frozen
from ..som.som import SOM
from .packing import check_manifest
from .reader import read_tensors, reading

_TENSORS = {
    "metric": ("f8",),
    "hits": ("i4",),
    "edges": ("i4",),
    "blocked": ("i4",),
    "perceptual": ("f4", "f8"),
    "view_positions": ("f8",),
    "entry_panorama": ("f4",),
}
"""Name -> the types that it may have."""


@dataclass(frozen=True, slots=True)
class StoredLocalMaps:
    """Gives the local maps of a file, each read when it is first used; until then nothing is held open."""

    path: Path

    def __call__(self, node: int, manifest: str) -> LocalMap:
        """The local map of a node whose row has this manifest."""
        return LocalMap(_Unread(self.path.absolute(), node, manifest))


@dataclass(frozen=True, slots=True)
class _Unread:
    """Reads one local map when called. The manifest tells if the file holds another one by then."""

    path: Path
    node: int
    manifest: str

    def __call__(self) -> LocalMapContent:
        with reading(self.path) as connection:
            return read_local_map(connection, self.node, self.manifest)


def read_local_map(connection: sqlite3.Connection, node: int, manifest: str) -> LocalMapContent:
    """The local map of a node, verified. Raises: MapFileDamagedError, sqlite3.Error."""
    return unpack_local_map(manifest, read_tensors(connection, node), f"node {node}")


def unpack_local_map(manifest: str, data: bytes, where: str) -> LocalMapContent:
    """The inverse of `pack_local_map`, everything checked. Raises: MapFileDamagedError."""
    about = check_manifest(manifest, data, where)
    try:
        tensors = _slice(about["tensors"], data)
        perceptual = about["perceptual"]
        return LocalMapContent(
            metric=_som(about["metric"], tensors["metric"]),
            hits=frozen(tensors["hits"].astype(np.int64)),
            edges=frozen(tensors["edges"].astype(np.int64)),
            entry_heading=_number(about["entry_heading"]),
            perceptual=None if perceptual is None else _som(perceptual, tensors["perceptual"]),
            view_positions=tensors.get("view_positions"),
            view_error=_number(about["view_error"]),
            entry_panorama=tensors.get("entry_panorama"),
            blocked=frozenset((int(i), int(j)) for i, j in tensors["blocked"]),
            locating=about["locating"],
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise MapFileDamagedError(f"{where}: the local map is not well-formed: {error!s:.200}") from None


def _som(shape: list[Any], weights: NDArray[Any]) -> SOM:
    rows, cols, topology = shape
    if type(rows) is not int or type(cols) is not int:
        raise ValueError(f"a SOM of {rows!r} x {cols!r} units")
    return SOM(rows, cols, topology, weights)


def _number(value: object) -> float:
    if not isinstance(value, float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    return value


def _slice(listed: list[Any], data: bytes) -> dict[str, NDArray[Any]]:
    tensors: dict[str, NDArray[Any]] = {}
    offset = 0
    for name, code, shape in listed:
        if code not in _TENSORS[name] or name in tensors:
            raise ValueError(f"tensor {name!r} is there twice or of type {code!r:.20}")
        if not all(type(size) is int and 0 <= size <= len(data) for size in shape):
            raise ValueError(f"tensor {name!r} has no valid shape")
        dtype = np.dtype(f"<{code}")
        count = math.prod(shape)
        if offset + count * dtype.itemsize > len(data):
            raise ValueError(f"tensor {name!r} goes beyond the bytes there are")
        array = np.frombuffer(data, dtype, count, offset).reshape(shape)
        tensors[name] = frozen(array.astype(dtype.newbyteorder("=")))
        offset += count * dtype.itemsize
    if offset != len(data):
        raise ValueError(f"{len(data) - offset} bytes are left over")
    return tensors
