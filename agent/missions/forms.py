"""What the fields of a step take: in words, as a check, and how they are read from YAML."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from functools import cache
from numbers import Integral, Real
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_type_hints

if TYPE_CHECKING:
    from ...files.yaml_nodes import Entry


@dataclass(frozen=True, slots=True)
class Form:
    """What a field of a step takes. says: in words. fits: whether a value is one.

    read: makes it of a YAML value, where its plain data is not enough. steps: whether it takes steps.
    """

    says: str
    fits: Callable[[Any], bool]
    read: Callable[[Entry], Any] | None = None
    steps: bool = False


def _number(kind: Any, low: float) -> Callable[[Any], bool]:
    def fits(value: Any) -> bool:
        return isinstance(value, kind) and not isinstance(value, bool) and bool(low <= value < math.inf)

    return fits


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


_is_whole = _number(Integral, -math.inf)
Seconds = Annotated[float, Form("a finite number of seconds, 0 or more", _number(Real, 0))]
Count = Annotated[int, Form("a whole number, 0 or more", _number(Integral, 0))]
Positive = Annotated[int, Form("a whole number, 1 or more", _number(Integral, 1))]
Node = Annotated[
    int | str, Form("a node's number or name", lambda value: _is_text(value) or _is_whole(value))
]
File = Annotated[str, Form("a file", lambda value: _is_text(value) and value != "" and "\0" not in value)]
Name = Annotated[str, Form("a name", _is_text)]
Text = Annotated[str, Form("a text", _is_text, lambda entry: entry.text())]
Flag = Annotated[bool, Form("true or false", lambda value: isinstance(value, bool))]


def one_of(*words: str) -> Form:
    """The form of a field that takes one of these words."""
    return Form(f"one of {', '.join(words)}", lambda value: isinstance(value, str) and value in words)


@cache
def forms_of(cls: type[Any]) -> dict[str, tuple[Form, bool]]:
    """The fields of a step's class that have a form, each with whether it may be None."""
    found = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        for part in (hint, *get_args(hint)):
            for form in getattr(part, "__metadata__", ()):
                if isinstance(form, Form):
                    found[name] = (form, type(None) in get_args(hint))
    return found


def values_of(cls: Any, entry: Entry, body: Callable[[Entry], Any]) -> dict[str, Any]:
    """The values that YAML gives for the fields of a step of this class. body: makes steps of a value."""
    yaml_names = {name: key for key, name in cls.keys.items()}
    specs = {yaml_names.get(each.name, each.name): each for each in fields(cls)}
    given: dict[str, Entry] = {}
    if cls.single and not entry.is_mapping and not entry.is_nothing:
        given = {cls.single: entry}
    elif not entry.is_nothing:
        given = entry.mapping(specs)
    forms, values = forms_of(cls), {}
    for key, spec in specs.items():
        form, optional = forms.get(spec.name, (None, True))
        if key in given:
            values[spec.name] = _value(given[key], form, optional, body)
        elif form is not None and spec.default is spec.default_factory is MISSING:
            raise entry.error(f"{key!r} is missing: give {form.says}")
    return values


def _value(entry: Entry, form: Form | None, optional: bool, body: Callable[[Entry], Any]) -> Any:
    if optional and entry.is_nothing:
        return None
    if form is None:
        return entry.data()
    if form.steps:
        return body(entry)
    value = entry.data() if form.read is None else form.read(entry)
    if not form.fits(value):
        raise entry.error(f"give {form.says}, not {entry.found()}")
    return value
