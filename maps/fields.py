"""What a map, a node and an arc have: declared here once.

SQL, rows, JSON and its schema, GraphML, GeoJSON, checks and the keywords of `HybridMap.add_node` follow from
these lines. To add a field, write one line with its type, range and default. It is stored beside the notes,
under a key that begins with `tolman:`, so that files stay readable both ways; `column` is for those that have
had a column of their own since a version of the map file.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral, Real
from typing import Annotated, Any, Literal, NamedTuple, TypedDict, get_type_hints

Side = Literal["right", "left"]
Kind = Literal["right", "left", "foray"]
Corner = Literal["concave", "convex", "none"]
Scalar = str | int | float | bool | None

MAX_METERS = 1e6
"""Nothing in a map is farther or longer (m)."""
MAX_ANGLE = 1e4
"""Headings and turns (rad) need not be wrapped, but are no larger."""
LONGEST = 200
"""Characters of a text."""
HIDDEN = "tolman:"
"""How the keys of notes begin under which fields without a column are stored."""


class _Kind(NamedTuple):
    """keep: the value as a map keeps it, None if it is of another type."""

    words: str
    sql: str
    schema: dict[str, Any]
    keep: Callable[[Any], Any]


def is_scalar(value: object) -> bool:
    """Whether a value is a JSON scalar that round-trips: str, bool, None, finite float, 64-bit int."""
    if isinstance(value, int) and not isinstance(value, bool):
        return -(2**63) <= value < 2**63
    return isinstance(value, str | bool | None) or (isinstance(value, float) and math.isfinite(value))


def _real(value: Any) -> float | None:
    if type(value) is float:  # nearly always, and faster
        return value
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else None
    except OverflowError:
        return None


def _integer(value: Any) -> int | None:
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else None


def _table(allowed: Callable[[object], bool]) -> Callable[[Any], Any]:
    def keep(value: Any) -> dict[str, Any] | None:
        fits = isinstance(value, Mapping) and all(isinstance(k, str) and allowed(v) for k, v in value.items())
        return dict(value) if fits else None

    return keep


_SCALARS = {"type": ["string", "number", "boolean", "null"]}
_KINDS = {
    "integer": _Kind(
        "a whole number",
        "INTEGER",
        {"type": "integer"},
        lambda value: value if type(value) is int else _integer(value),
    ),
    "real": _Kind("a number", "REAL", {"type": "number"}, _real),
    "text": _Kind(
        "a printable text",
        "TEXT",
        {"type": "string"},
        lambda value: str(value) if isinstance(value, str) and value.isprintable() else None,
    ),
    "flag": _Kind(
        "true or false",
        "INTEGER",
        {"type": "boolean"},
        lambda value: value if isinstance(value, bool) else None,
    ),
    "notes": _Kind("a JSON object", "TEXT", {"type": "object"}, _table(lambda _: True)),
    "texts": _Kind(
        "an object of strings",
        "TEXT",
        {"type": "object", "additionalProperties": {"type": "string"}},
        _table(lambda value: isinstance(value, str)),
    ),
    "scalars": _Kind(
        "an object of finite JSON scalars",
        "TEXT",
        {"type": "object", "additionalProperties": _SCALARS},
        _table(is_scalar),
    ),
}


@dataclass(frozen=True)
class Field:
    """One value of a node, an arc or a map.

    kind: as in `_KINDS`. low, high: range of a number. choices: the only texts. shortest: characters of a
    text. empty: whether None is allowed. default: what there is without one (...: it must be given). column:
    version of the map file since which it has a column. route: whether route planners see it (GeoJSON); other
    exports have all fields.
    """

    kind: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    shortest: int = 0
    empty: bool = False
    default: Any = ...
    column: int | None = None
    route: bool = False
    name: str = ""

    def clean(self, value: Any) -> Any:
        """The value as a map keeps it: plain Python. Raises: ValueError that says what is expected."""
        if value is None and self.empty:
            return None
        kept = _KINDS[self.kind].keep(value)
        if kept is None or not self._fits(kept):
            raise ValueError(f"{self.name} = {value!r:.60}: expected {self.expected}")
        return kept

    def _fits(self, value: Any) -> bool:
        if self.kind in ("integer", "real"):
            return bool(self.low <= value <= self.high) and not math.isinf(value)
        if self.kind == "text":
            return value in self.choices if self.choices else self.shortest <= len(value) <= LONGEST
        return True

    @cached_property
    def expected(self) -> str:
        """What a value must be, in words."""
        what = " or ".join(self.choices) or _KINDS[self.kind].words + (
            f" in {self.unit}" if self.unit else ""
        )
        if self.kind == "text" and not self.choices:
            what += f" of {self.shortest} to {LONGEST} characters"
        if math.isfinite(self.low):
            what += f" from {self.low:.12g}" + (f" to {self.high:.12g}" if math.isfinite(self.high) else "")
        return what + (" or none" if self.empty else "")

    @property
    def sql(self) -> str:
        """The declaration of its column."""
        name = '"end"' if self.name == "end" else self.name
        return f"{name} {_KINDS[self.kind].sql}" + ("" if self.empty else " NOT NULL")

    @property
    def schema(self) -> dict[str, Any]:
        """Its JSON Schema."""
        found: dict[str, Any] = (
            {"enum": list(self.choices)} if self.choices else dict(_KINDS[self.kind].schema)
        )
        for key, limit in (("minimum", self.low), ("maximum", self.high)):
            if math.isfinite(limit):
                found[key] = limit
        return {"anyOf": [found, {"type": "null"}]} if self.empty else found

    def scalar(self, value: Any) -> Scalar:
        """The value as a scalar; notes as JSON text."""
        return json.dumps(dict(value), sort_keys=True) if isinstance(value, Mapping) else value


def declared(declaring: type) -> tuple[Field, ...]:
    """The fields of a class annotated by `Annotated[type, Field(...)]`; a dataclass's defaults hold."""
    found = []
    own = getattr(declaring, "__dataclass_fields__", {})
    for name, hint in get_type_hints(declaring, include_extras=True).items():
        about: Field = dataclasses.replace(hint.__metadata__[0], name=name)
        if name in own and own[name].default is not dataclasses.MISSING:
            about = dataclasses.replace(about, default=own[name].default)
        elif name in own and own[name].default_factory is not dataclasses.MISSING:
            about = dataclasses.replace(about, default=own[name].default_factory())
        found.append(about)
    return tuple(found)


@dataclass(frozen=True)
class Record:
    """All fields of one kind of thing. keys: those that tell one from another, in order."""

    name: str
    keys: tuple[Field, ...]
    fields: tuple[Field, ...]

    @cached_property
    def by_name(self) -> dict[str, Field]:
        """The fields that are no keys."""
        return {each.name: each for each in self.fields}

    def label(self, key: Sequence[Any]) -> str:
        """What a message calls one: `node 3`, `arc 0 -> 1 (right)`."""
        told = [
            f"{each:.40}" if type(each) is str and each.isprintable() else f"{each!r:.40}" for each in key
        ]
        return (
            f"{self.name} {told[0]} -> {told[1]} ({told[2]})"
            if len(told) == 3
            else " ".join([self.name, *told])
        )

    def clean(self, key: Sequence[Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """All fields as a map keeps them, in order, defaults filled in.

        Raises: ValueError, one line that names the node or arc and says what is expected.
        """
        try:
            for each, part in zip(self.keys, key, strict=True):
                if type(part) not in (
                    int,
                    str,
                ):  # a numpy integer or 7.0 is another key than 7 in some places
                    raise ValueError(
                        f"{each.name} = {part!r:.40} ({type(part).__name__}): expected {each.expected}"
                    )
                each.clean(part)
            if not values.keys() <= self.by_name.keys():
                unknown = min(map(str, values.keys() - self.by_name.keys()))
                raise ValueError(f"unknown field {unknown!r:.40}; known: {', '.join(self.by_name)}")
            return {each.name: self._value(each, values) for each in self.fields}
        except ValueError as error:
            raise ValueError(f"{self.label(key)}: {error}") from None

    @staticmethod
    def _value(each: Field, values: Mapping[str, Any]) -> Any:
        value = values.get(each.name, each.default)
        if value is ...:
            raise ValueError(f"it has no {each.name}")
        return each.clean(value)

    def columns(self, version: int) -> tuple[Field, ...]:
        """The fields that have a column in that version of the map file, keys first."""
        return *self.keys, *(each for each in self.fields if each.column and each.column <= version)

    def schema(self) -> dict[str, Any]:
        """The JSON Schema of each field by name, keys first."""
        return {each.name: each.schema for each in (*self.keys, *self.fields)}


def number(name: str, empty: bool = False) -> Field:
    """The number of a node."""
    return Field("integer", low=0, high=2**31 - 1, name=name, empty=empty)


_NODE = number("")
_ANGLE: dict[str, Any] = {"kind": "real", "unit": "rad", "low": -MAX_ANGLE, "high": MAX_ANGLE, "column": 1}
SIDES, KINDS = ("right", "left"), ("right", "left", "foray")


class NodeValues(TypedDict, total=False):
    """A node, beside its local map. turn: of the boundary there when driven in the mapping direction.

    entry_heading: map frame. notes: free JSON.
    """

    name: Annotated[str, Field("text", shortest=1, column=1, route=True)]
    corner: Annotated[
        str, Field("text", choices=("concave", "convex", "none"), default="none", column=1, route=True)
    ]
    turn: Annotated[float, Field(**_ANGLE, default=0.0)]
    entry_heading: Annotated[float, Field(**_ANGLE, default=0.0)]
    notes: Annotated[Mapping[str, Any], Field("notes", default={}, column=1)]


@dataclass(frozen=True, slots=True)
class Arc:
    """A way from one node to another: the side to follow, and for how far.

    kind: the arc's key in the graph. distance: mean path length, m. variance: of one traversal, m^2.
    traversals: how often it was driven. notes: free JSON, e.g. the heading of a foray.
    """

    start: Annotated[int, _NODE]
    end: Annotated[int, _NODE]
    kind: Annotated[str, Field("text", choices=KINDS, column=1, route=True)]
    side: Annotated[str, Field("text", choices=SIDES, column=1, route=True)]
    distance: Annotated[float, Field("real", "m", 0, MAX_METERS, column=1, route=True)]
    variance: Annotated[float, Field("real", "m^2", 0, MAX_METERS**2, column=1)] = 0.0
    traversals: Annotated[int, Field("integer", low=0, high=2**31 - 1, column=1)] = 1
    blocked: Annotated[bool, Field("flag", column=1)] = False
    notes: Annotated[Mapping[str, Any], Field("notes", column=1)] = dataclasses.field(default_factory=dict)

    def values(self) -> dict[str, Any]:
        """What the graph keeps with it: all but its key."""
        return {name: getattr(self, name) for name in ARC.by_name}


NODE = Record("node", (number("id"),), declared(NodeValues))
ARC = Record("arc", declared(Arc)[:3], declared(Arc)[3:])
