"""The file of settings (--config): four sections of YAML, each checked when it is read.

    behaviors: {wall-following: {speed: 200}}     # settings by behavior, other than the profile's
    mapping: {wall_distance: 0.06}                # settings of the profile's mapper
    mediator: blend                               # or {name: blend, reflex: 40}: its name and its options
    noise: {preset: none, encoder: 0.01}          # values, on top of a preset

What is read is plain data, as it also stands in the header of a recording, where it is read from again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from ...agent.mapping.corners import MappingConfig
from ...agent.mapping.published import ThesisMappingConfig
from ...files.messages import quoted, unknown
from ...files.reading import read_text
from ...files.yaml_nodes import Entry, parse_yaml
from ...world.noise.model import NAMES
from ..errors import SessionError

if TYPE_CHECKING:
    from .profiles import Profile

LIMIT = 1 << 20
"""Bytes of a file of settings."""
_KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text", NoneType: "null"}
DEFAULT_MEDIATOR = "priority"

_FROM_REQUEST = ("side", "local_maps", "strategy", "max_nodes")
"""Fields of a mapper's settings that a request sets, and a file of settings cannot."""

Settings = dict[str, Any]
"""By section; one that is not there is as the profile has it."""


def load_settings(path: Path | None) -> Settings:
    """The settings of a YAML file; none for None. Raises: SessionError naming file, line and key."""
    if path is None:
        return {}
    return parse_settings(read_text(path, LIMIT, SessionError), str(path))


def parse_settings(text: str, source: str) -> Settings:
    """The settings in the text of a file. Raises: SessionError naming `source`, line and key."""
    top = parse_yaml(text, source, SessionError)
    if top.is_nothing:
        return {}
    sections = top.mapping(_SECTIONS)
    return {name: _SECTIONS[name](entry) for name, entry in sections.items() if not entry.is_nothing}


def recorded_settings(values: object, source: str) -> Settings:
    """The settings that a recording's header holds, checked as those of a file. Raises: SessionError."""
    return parse_settings(json.dumps(values, ensure_ascii=False, default=str), f"{source}: its settings")


def mediator_of(settings: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Name and options of the mediator that settings ask for."""
    asked = settings.get("mediator", DEFAULT_MEDIATOR)
    if isinstance(asked, str):
        return asked, {}
    options = dict(asked)
    return options.pop("name"), options


def configured(profile: Profile, settings: Mapping[str, Any]) -> Profile:
    """The profile with what the section `mapping` of a file of settings asks of its mapper.

    Raises: SessionError naming the setting. What a command line says (side, limits) is not set there.
    """
    asked = settings.get("mapping")
    if not asked:
        return profile
    kind: type[Any] = ThesisMappingConfig if profile.mapper == "turns" else MappingConfig
    base = kind(**profile.mapping)
    if profile.mapper == "turns":
        base = replace(base, closing=profile.closing)
    values = updated_fields(base, asked, "mapping", _FROM_REQUEST)
    closing = values.pop("closing", profile.closing) if profile.mapper == "turns" else profile.closing
    return replace(profile, mapping={**profile.mapping, **values}, closing=closing)


def updated_fields(
    base: Any, values: Mapping[str, Any], where: str, fixed: Sequence[str] = ()
) -> dict[str, Any]:
    """The fields of a dataclass that `values` change, each of its field's type; nested ones whole.

    base: an instance with what is there before. fixed: fields that cannot be set.

    Raises: SessionError for an unknown field or a value of another type; `where` begins the message.
    """
    hints = get_type_hints(type(base))
    known = [field.name for field in fields(base) if field.name not in fixed]
    changes = {}
    for name, value in values.items():
        if name not in known:
            raise SessionError(f"{where}: {unknown('setting', name, known)}")
        changes[name] = _fitted(value, getattr(base, name), hints[name], f"{where}.{name}")
    return changes


def _fitted(value: Any, before: Any, hint: Any, where: str) -> Any:
    if is_dataclass(before):
        if not isinstance(value, Mapping):
            raise SessionError(f"{where}: expected settings by name, found {quoted(value)}")
        return replace(before, **updated_fields(before, value, where))  # type: ignore[type-var]
    kinds = get_args(hint) or (hint,)
    if type(value) is int and int not in kinds and float in kinds:
        value = float(value)
    if type(value) not in kinds:
        names = " or ".join(_KINDS.get(kind, kind.__name__) for kind in kinds)
        raise SessionError(f"{where}: expected {names}, found {quoted(value)}")
    return value


def _behaviors(entry: Entry) -> dict[str, dict[str, Any]]:
    found = entry.mapping().items()
    return {name: {} if values.is_nothing else _values(values) for name, values in found}


def _values(entry: Entry) -> dict[str, Any]:
    return {name: value.data() for name, value in entry.mapping().items()}


def _mediator(entry: Entry) -> str | dict[str, Any]:
    if entry.is_list:
        raise entry.error("give a mediator's name, or `name:` with its options, not a list")
    if entry.is_scalar:
        return entry.text()
    keys = entry.mapping(required=("name",))
    return {"name": keys.pop("name").text(), **{name: value.data() for name, value in keys.items()}}


def _noise(entry: Entry) -> dict[str, float | str]:
    keys = entry.mapping(("preset", *NAMES))
    return {name: each.text() if name == "preset" else each.number() for name, each in keys.items()}


_SECTIONS: Mapping[str, Callable[[Entry], Any]] = {
    "behaviors": _behaviors,
    "mapping": _values,
    "mediator": _mediator,
    "noise": _noise,
}
