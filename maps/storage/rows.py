"""Nodes and arcs to the rows of a map file and back, as `fields` declares them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import MapError
from ..fields import HIDDEN, Field, Record
from .schema import CURRENT
from .values import Value, dump_json, parse_object


def to_row(record: Record, key: Sequence[Any], values: Mapping[str, Any]) -> tuple[Value, ...]:
    """The columns of a node or an arc. Raises: MapError when it cannot be stored."""
    try:
        clean = record.clean(key, values)
    except ValueError as error:
        raise MapError(str(error)) from None
    notes = dict(clean["notes"])
    for each in _without_column(record):
        if clean[each.name] != each.default:
            notes[HIDDEN + each.name] = clean[each.name]
    clean["notes"] = dump_json(notes, f"{record.label(key)}: notes")
    stored = record.columns(CURRENT.version)[len(key) :]
    return (*key, *(int(v) if isinstance(v := clean[each.name], bool) else v for each in stored))


def from_row(record: Record, row: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Key and values of a node or an arc. Raises: MapError when they are none that a map may have."""
    count = len(record.keys)
    key = tuple(row[:count])
    values: dict[str, Any] = {}
    for each, stored in zip(record.columns(CURRENT.version)[count:], row[count:], strict=False):
        values[each.name] = bool(stored) if each.kind == "flag" and stored in (0, 1) else stored
    notes = values["notes"]
    values["notes"] = {} if notes == "{}" else parse_object(notes, f"{record.label(key)}: notes")
    for each in _without_column(record):
        values[each.name] = values["notes"].pop(HIDDEN + each.name, each.default)
    try:
        return key, record.clean(key, values)
    except ValueError as error:
        raise MapError(str(error)) from None


def _without_column(record: Record) -> tuple[Field, ...]:
    return tuple(each for each in record.fields if not each.column)
