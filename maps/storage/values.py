"""Values in the rows of a map file: their checksum, and JSON texts. See docs/format.md."""

from __future__ import annotations

import hashlib
import json
import struct
from typing import Any

from ..errors import MapError, MapFileDamagedError

Value = int | float | str | bytes | None
JSON_LIMIT = 4096
"""Longest JSON text (characters) in a row that is not the session's or the truth's."""


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
