"""What people give (settings, goals, options) checked against the typed fields of a dataclass.

A mapping, as YAML and JSON have it, becomes an instance: lists become tuples, names members of an Enum,
nested mappings dataclasses. An instance is checked field by field. All errors are one line that names the
field. `Annotated[str, ("right", "left")]` is the type of a field that takes only these texts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass, replace
from enum import Enum
from functools import lru_cache
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from ..files.messages import unknown
from .errors import ConfigError


def configured(owner: str, cls: type[Any], config: Any, settings: Mapping[str, Any]) -> Any:
    """The configuration of `owner`: `config` if it is a `cls`, else a new `cls` with these settings.

    Raises: ConfigError for another class, an unknown name or a value of the wrong type.
    """
    if config is None:
        return build(cls, settings, owner, "setting")
    if not isinstance(config, cls):
        raise ConfigError(f"{owner}: config must be a {cls.__name__}, not {type(config).__name__}")
    return config


def build(cls: type[Any], values: Mapping[str, Any], owner: str, word: str = "field") -> Any:
    """A `cls` with these values by field; `owner` begins every error, `word` says what a field is there.

    Raises: ConfigError for an unknown or missing field, or a value that does not fit.
    """
    known = {each.name: each for each in fields(cls) if each.init}
    for key in values:
        if key not in known:
            raise ConfigError(f"{owner}: {unknown(word, key, sorted(known))}")
    missing = [each.name for each in known.values() if _is_required(each) and each.name not in values]
    if missing:
        raise ConfigError(f"{owner}: {cls.__name__} needs {', '.join(missing)}")
    hints = _hints(cls)
    given = {key: _fitted(value, hints.get(key, Any), f"{owner}: {key}") for key, value in values.items()}
    try:
        return cls(**given)
    except ValueError as fault:
        raise ConfigError(f"{owner}: {fault}") from fault


def fitted(cls: type[Any], value: Any, what: str) -> Any:
    """A `cls`, checked: the value itself, or made of a mapping, also one that the codec read (`$` names it).

    what: begins every error. Raises: ConfigError.
    """
    if isinstance(value, cls):
        return verified(value, what)
    if isinstance(value, Mapping):
        name = value.get("$", cls.__name__)
        if name != cls.__name__:
            raise ConfigError(f"{what} must be a {cls.__name__}, not a {name}")
        return build(cls, {key: each for key, each in value.items() if key != "$"}, what)
    raise ConfigError(f"{what} must be a {cls.__name__}, not {value!r}")


def verified(value: Any, owner: str) -> Any:
    """The dataclass instance, its fields checked. Raises: ConfigError for a value that does not fit."""
    hints, changed = _hints(type(value)), {}
    for each in fields(value):
        held = getattr(value, each.name)
        wanted = _fitted(held, hints.get(each.name, Any), f"{owner}: {each.name}")
        if wanted is not held and each.init:
            changed[each.name] = wanted
    return replace(value, **changed) if changed else value


def needs_values(cls: type[Any]) -> bool:
    """Whether some field of the dataclass has no default."""
    return any(_is_required(each) for each in fields(cls))


def _is_required(each: Any) -> bool:
    return bool(each.init and each.default is MISSING and each.default_factory is MISSING)


def _hints(cls: Any) -> Mapping[str, Any]:
    return _hints_of(cls)


@lru_cache(maxsize=256)
def _hints_of(cls: type[Any]) -> Mapping[str, Any]:
    """The types of the fields; those that cannot be found, such as a function's own, are not checked."""
    try:
        return get_type_hints(cls, include_extras=True)
    except (NameError, TypeError, AttributeError):
        return {}


def _fitted(value: Any, hint: Any, what: str) -> Any:
    """The value as the type wants it. Raises: ConfigError."""
    origin = get_origin(hint)
    if origin is Annotated:
        base, *marks = get_args(hint)
        value = _fitted(value, base, what)
        for mark in marks:
            if isinstance(mark, tuple) and value is not None and value not in mark:
                raise ConfigError(f"{what} must be {' or '.join(mark)}, not {value!r}")
        return value
    if origin in (Union, UnionType):
        return _fitted_to_one(value, get_args(hint), what)
    if origin is tuple or hint is tuple:
        return _fitted_tuple(value, get_args(hint), what)
    if hint is Any or not isinstance(hint, type):
        return value
    if is_dataclass(hint):
        return fitted(hint, value, what)
    if issubclass(hint, Enum):
        return _fitted_enum(value, hint, what)
    return _fitted_simple(value, hint, what)


def _fitted_to_one(value: Any, options: tuple[Any, ...], what: str) -> Any:
    if value is None and NoneType in options:
        return None
    options = tuple(option for option in options if option is not NoneType)
    for option in options[:-1]:
        try:
            return _fitted(value, option, what)
        except ConfigError:
            continue
    return _fitted(value, options[-1], what)


def _fitted_tuple(value: Any, kinds: tuple[Any, ...], what: str) -> Any:
    if not isinstance(value, tuple | list):
        raise ConfigError(f"{what} must be a list, not {value!r}")
    if not kinds:
        return tuple(value)
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        raise ConfigError(f"{what} must be a list of {len(kinds)}, not {value!r}")
    made = [
        _fitted(each, kind, f"{what}[{i}]") for i, (each, kind) in enumerate(zip(value, kinds, strict=True))
    ]
    same = isinstance(value, tuple) and all(a is b for a, b in zip(made, value, strict=True))
    return value if same else tuple(made)


def _fitted_enum(value: Any, cls: type[Enum], what: str) -> Any:
    if isinstance(value, cls):
        return value
    for member in cls:
        if value in (member.value, member.name, f"{cls.__name__}.{member.name}"):
            return member
    raise ConfigError(f"{what} must be one of {', '.join(str(each.value) for each in cls)}, not {value!r}")


def _fitted_simple(value: Any, kind: type[Any], what: str) -> Any:
    if kind is bool:
        fits, name = isinstance(value, bool), "true or false"
    elif kind is int:
        fits, name = isinstance(value, Integral) and not isinstance(value, bool), "a whole number"
    elif kind is float:
        fits = isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
        name = "a finite number"
    elif kind is str:
        fits, name = isinstance(value, str), "a text"
    else:
        fits, name = isinstance(value, kind), f"a {kind.__name__}"
    if not fits:
        raise ConfigError(f"{what} must be {name}, not {value!r}")
    return value
