"""Rows of a map file as plain values, their checksums, local maps as bytes: see docs/format.md."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import MapError, MapFileDamagedError
from ..local.content import LocalMapContent
from ..som.lattice import frozen
from ..som.som import SOM

Value = int | float | str | bytes | None
JSON_LIMIT = 4096
"""Longest JSON text (characters) in a row that is not the session's or the truth's."""


class NodeRow(NamedTuple):
    """One node. notes: JSON object. local_map: JSON manifest of the bytes in `tensors`, or None."""

    id: int
    name: str
    corner: str
    turn: float
    entry_heading: float
    notes: str
    local_map: str | None


class ArcRow(NamedTuple):
    """One arc. notes: JSON object."""

    start: int
    end: int
    kind: str
    side: str
    distance: float
    variance: float
    traversals: int
    blocked: int
    notes: str


def row_hash(table: str, values: tuple[Value, ...]) -> int:
    """The checksum of a row: the first 8 bytes, little-endian signed, of BLAKE2b over table and values."""
    parts = [table.encode(), b"\0"]
    for value in values:
        if isinstance(value, float):
            parts.append(b"R" + struct.pack("<d", value))
        elif isinstance(value, int):
            parts.append(b"I" + struct.pack("<q", value))
        elif isinstance(value, str):
            text = value.encode()
            parts.append(b"T" + struct.pack("<q", len(text)) + text)
        elif value is None:
            parts.append(b"N")
        else:
            parts.append(b"B" + struct.pack("<q", len(value)) + value)
    return int.from_bytes(hashlib.blake2b(b"".join(parts), digest_size=8).digest(), "little", signed=True)


def wrap_sum(value: int) -> int:
    """An integer wrapped into signed 64 bits, as sums of checksums are."""
    return (value + 2**63) % 2**64 - 2**63


def dump_json(value: Any, what: str, limit: int = JSON_LIMIT) -> str:
    """Canonical JSON: sorted keys, no spaces, ASCII. Raises: MapError when it is none or too long."""
    try:
        text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
        if json.loads(text) != value:
            raise ValueError("it does not come back equal (keys must be strings, sequences lists)")
    except (TypeError, ValueError, RecursionError) as error:
        raise MapError(f"{what} cannot be stored as JSON: {error}") from None
    if len(text) > limit:
        raise MapError(f"{what} takes {len(text)} characters of JSON: at most {limit}")
    return text


def parse_json(text: str, what: str, limit: int = JSON_LIMIT) -> Any:
    """Strict JSON from a file: no NaN, no doubled keys. Raises: MapFileDamagedError."""
    if len(text) > limit:
        raise MapFileDamagedError(f"{what} takes {len(text)} characters of JSON: at most {limit}")
    try:
        return json.loads(text, parse_constant=_refuse, object_pairs_hook=_pairs)
    except (ValueError, RecursionError) as error:
        raise MapFileDamagedError(f"{what} is no valid JSON: {error}") from None


def parse_object(text: str, what: str, limit: int = JSON_LIMIT) -> dict[str, Any]:
    """A JSON object from a file. Raises: MapFileDamagedError."""
    value = parse_json(text, what, limit)
    if not isinstance(value, dict):
        raise MapFileDamagedError(f"{what} is JSON, but not an object")
    return value


def _refuse(name: str) -> float:
    raise ValueError(f"{name} is not allowed")


def _pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a key occurs twice")
    return found


_DTYPES = {"f8": "<f8", "f4": "<f4", "i4": "<i4"}


def pack_local_map(content: LocalMapContent) -> tuple[str, bytes]:
    """A local map as JSON manifest and the bytes of its tensors, one after another."""
    tensors: dict[str, NDArray[Any]] = {
        "metric": content.metric.weights.astype(np.float64),
        "hits": content.hits.astype(np.int32),
        "edges": content.edges.astype(np.int32).reshape(-1, 2),
        "blocked": np.array(sorted(content.blocked), dtype=np.int32).reshape(-1, 2),
    }
    if content.perceptual is not None and content.view_positions is not None:
        tensors["perceptual"] = content.perceptual.weights
        tensors["view_positions"] = content.view_positions.astype(np.float64)
    if content.entry_panorama is not None:
        tensors["entry_panorama"] = content.entry_panorama.astype(np.float32)
    data = b"".join(np.ascontiguousarray(t, t.dtype.newbyteorder("<")).tobytes() for t in tensors.values())
    manifest = {
        "metric": _shape(content.metric),
        "perceptual": None if content.perceptual is None else _shape(content.perceptual),
        "entry_heading": content.entry_heading,
        "view_error": content.view_error,
        "locating": content.locating,
        "tensors": [
            [name, f"{t.dtype.kind}{t.dtype.itemsize}", list(t.shape)] for name, t in tensors.items()
        ],
        "bytes": len(data),
        "hash": hashlib.blake2b(data, digest_size=16).hexdigest(),
    }
    return dump_json(manifest, "a local map's manifest"), data


def _shape(som: SOM) -> list[Any]:
    return [som.rows, som.cols, som.topology]


def unpack_local_map(manifest: str, data: bytes, where: str) -> LocalMapContent:
    """The inverse of `pack_local_map`, everything checked. Raises: MapFileDamagedError."""
    about = parse_object(manifest, f"{where}: the local map's manifest")
    if len(data) != about.get("bytes") or hashlib.blake2b(data, digest_size=16).hexdigest() != about.get(
        "hash"
    ):
        raise MapFileDamagedError(f"{where}: the local map's bytes do not match their checksum")
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
    except (KeyError, TypeError, ValueError) as error:
        raise MapFileDamagedError(f"{where}: the local map is not well-formed: {error}") from None


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
        dtype = np.dtype(_DTYPES[code])
        if not all(isinstance(size, int) and 0 <= size <= len(data) for size in shape) or name in tensors:
            raise ValueError(f"tensor {name!r} has no valid shape")
        count = math.prod(shape)
        if offset + count * dtype.itemsize > len(data):
            raise ValueError(f"tensor {name!r} goes beyond the bytes there are")
        array = np.frombuffer(data, dtype, count, offset).reshape(shape)
        tensors[name] = frozen(array.astype(dtype.newbyteorder("=")))
        offset += count * dtype.itemsize
    if offset != len(data):
        raise ValueError(f"{len(data) - offset} bytes are left over")
    return tensors
