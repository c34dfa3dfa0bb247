"""Events, goals, results and states as JSON and back: for recordings, journals, plugins in subprocesses.

A dataclass becomes `{"$": class name, field: value, ...}`, an enum member `{"$enum": "Class.NAME"}`, a tuple
`{"$tuple": [...]}`, an array `{"$array": nested lists, "dtype": ...}`, a float that is not finite
`{"$float": "nan"}`. Floats keep every bit. Reading executes nothing: an unknown class stays a dict.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

from ..world.robot import Pose, WheelCommand
from . import events, goals
from .errors import CodecError

_DEPTH = 20


def encode(value: Any, depth: int = 0) -> Any:
    """The value in JSON's own types. What has no form of its own becomes its class's name.

    Raises: CodecError beyond 20 levels of nesting.
    """
    if value is None or isinstance(value, bool | int | str):
        return value if not isinstance(value, Enum) else _enum(value)
    if depth > _DEPTH:
        raise CodecError(f"nested deeper than {_DEPTH} levels")
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else {"$float": repr(float(value))}
    if isinstance(value, Enum):
        return _enum(value)
    if is_dataclass(value) and not isinstance(value, type):
        body = {field.name: encode(getattr(value, field.name), depth + 1) for field in fields(value)}
        return {"$": type(value).__name__} | body
    if isinstance(value, Mapping):
        return {str(key): encode(item, depth + 1) for key, item in value.items()}
    if isinstance(value, tuple):
        return {"$tuple": [encode(item, depth + 1) for item in value]}
    if isinstance(value, list):
        return [encode(item, depth + 1) for item in value]
    if isinstance(value, set | frozenset):
        return sorted(encode(item, depth + 1) for item in value)
    return _encode_numpy(value)


def _enum(value: Enum) -> dict[str, str]:
    return {"$enum": f"{type(value).__name__}.{value.name}"}


def _encode_numpy(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return {"$array": value.tolist(), "dtype": str(value.dtype)}
    if isinstance(value, np.generic):
        return encode(value.item())
    return {"$": type(value).__name__}


def dumps(value: Any) -> str:
    """The value as one line of JSON: equal values give equal text."""
    return json.dumps(encode(value), separators=(",", ":"), sort_keys=True, allow_nan=False)


def _subclasses(cls: type[Any]) -> Iterable[type[Any]]:
    for sub in cls.__subclasses__():
        yield sub
        yield from _subclasses(sub)


def known_classes() -> dict[str, type[Any]]:
    """The dataclasses and enums that `decode` makes again, by name: events, goals, poses and commands."""
    known: dict[str, type[Any]] = {"Pose": Pose, "WheelCommand": WheelCommand}
    for name, value in vars(goals).items():
        if isinstance(value, type) and value.__module__ == goals.__name__:
            known[name] = value
    known |= {cls.__name__: cls for cls in _subclasses(events.Event) if cls.__module__ == events.__name__}
    return known


_CLASSES = known_classes()


def decode(value: Any, *classes: type[Any]) -> Any:
    """The value that `encode` was given, as far as its classes are known. classes: known here besides.

    Raises: CodecError for a known class with unknown or missing fields, and for what `encode` never makes.
    """
    try:
        return _decode(value, _CLASSES | {cls.__name__: cls for cls in classes})
    except (TypeError, ValueError, LookupError, RecursionError, OverflowError) as fault:
        raise CodecError(f"not a recorded value: {fault}") from fault


def _decode(value: Any, classes: Mapping[str, type[Any]]) -> Any:
    if isinstance(value, list):
        return [_decode(item, classes) for item in value]
    if not isinstance(value, dict):
        return value
    if "$tuple" in value:
        return tuple(_decode(item, classes) for item in value["$tuple"])
    if "$float" in value:
        return float(value["$float"])
    if "$array" in value:
        return _array(value)
    if "$enum" in value:
        name, _, member = str(value["$enum"]).partition(".")
        cls = classes.get(name)
        return cls[member] if cls is not None and issubclass(cls, Enum) else value["$enum"]
    body = {key: _decode(item, classes) for key, item in value.items() if key != "$"}
    cls = classes.get(str(value.get("$", "")))
    if cls is None:
        return body if "$" not in value else {"$": value["$"], **body}
    return cls(**body)


def _array(value: dict[str, Any]) -> Any:
    dtype = np.dtype(str(value["dtype"]))
    if dtype.kind not in "biuf":
        raise CodecError(f"an array of {dtype}, not of numbers")
    return np.array(value["$array"], dtype=dtype)


def loads(text: str) -> Any:
    """The value of one line that `dumps` wrote. Raises: CodecError if it is none."""
    try:
        return decode(json.loads(text))
    except (ValueError, RecursionError) as fault:
        raise CodecError(f"not a recorded value: {fault}") from fault


def snapshot(owner: Any, names: Iterable[str]) -> dict[str, Any]:
    """Attributes of an object as JSON values: what a resumed run needs of it."""
    return {name.lstrip("_"): encode(getattr(owner, name)) for name in names}


def reinstate(owner: Any, names: Iterable[str], state: Mapping[str, Any], *classes: type[Any]) -> None:
    """Sets these attributes as they were when a `snapshot` was taken. classes: as for `decode`."""
    for name in names:
        setattr(owner, name, decode(state[name.lstrip("_")], *classes))
