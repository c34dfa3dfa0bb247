"""A plugin's class as plain data, and a class made of such data that stands for it elsewhere.

What comes from a subprocess is not trusted: names, types and sizes are checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, field, fields, make_dataclass
from enum import Enum
from typing import Any

from ...agent.behavior import Behavior, Transition, check_declarations
from ...agent.codec import decode, encode
from ...agent.containment import describe
from ...agent.errors import CodecError
from ...files.messages import printable
from ..errors import BrokenPluginError
from ..loading import BEHAVIORS, KINDS

LONGEST = 200
"""Characters of a name or of the line about a plugin."""
MOST = 1000
"""States, rows of a table or fields of a dataclass."""


def description(cls: type[Any], group: str) -> dict[str, Any]:
    """What others need to know of a plugin's class, as JSON."""
    about = str(cls.__doc__ or "").strip().partition("\n")[0][:LONGEST]
    told = {"group": group, "name": cls.name, "about": about}
    if group != BEHAVIORS:
        return told
    return told | {
        "priority": cls.priority,
        "states": [state.name for state in cls.States],
        "initial": cls.initial.name,
        "transitions": [
            [row.trigger, [state.name for state in row.origins], row.target.name, row.when]
            for row in cls.transitions
        ],
        "config": _described_fields(cls.Config),
        "goal": None if cls.Goal is None else _described_fields(cls.Goal),
    }


def _described_fields(cls: type[Any]) -> list[Any]:
    """The name of a dataclass and each of its fields: its name, then, encoded, its default if it has one."""
    found: list[list[Any]] = []
    for each in fields(cls):
        if each.default_factory is not MISSING:
            found.append([each.name, encode(each.default_factory())])
        else:
            found.append([each.name] if each.default is MISSING else [each.name, encode(each.default)])
    return [cls.__name__, found]


def named(told: Mapping[str, Any]) -> tuple[str, str]:
    """Group and name of a plugin, by what a subprocess tells of it. Raises: BrokenPluginError."""
    group, name = told.get("group"), told.get("name")
    if group not in KINDS or not isinstance(name, str) or not name.isprintable() or len(name) > LONGEST:
        raise BrokenPluginError("a subprocess says nothing sensible of its plugin")
    return str(group), name


def behavior_class(base: type[Behavior], method: Any, told: Mapping[str, Any], **more: Any) -> type[Behavior]:
    """A behavior class with what is told of another: name, priority, states, table, settings and goal.

    base: has all else. method: of every state. more: further attributes. Raises: BrokenPluginError.
    """
    try:
        states = Enum(f"{told['name']}-states", {str(name): str(name) for name in told["states"][:MOST]})  # type: ignore[misc]
        if taken := [state.name for state in states if hasattr(base, state.name.lower())]:
            raise ValueError(f"a state cannot be named {printable(taken[0])}")
        methods = {state.name.lower(): method for state in states}
        rows = tuple(
            Transition(str(trigger), tuple(states[source] for source in sources), states[target], str(when))
            for trigger, sources, target, when in told["transitions"][:MOST]
        )
        conditions = {row.when: _always for row in rows if row.when and not hasattr(base, row.when)}
        about = printable(str(told["about"])[:LONGEST])
        body = {
            "name": told["name"],
            "priority": told["priority"],
            "States": states,
            "initial": states[told["initial"]],
            "transitions": rows,
            "Config": _data_class(*told["config"]),
            "Goal": _data_class(*told["goal"]) if told["goal"] else None,
            "__doc__": f"{about} (isolated)",
            "__module__": base.__module__,
        }
        cls = type("Isolated", (base,), conditions | methods | body | more)
        check_declarations(cls)
    except (KeyError, TypeError, ValueError, AttributeError, CodecError) as fault:
        raise BrokenPluginError(f"its subprocess says nothing sensible: {describe(fault)}") from fault
    return cls


def _always(behavior: Any) -> bool:
    return True


def _data_class(name: str, described: list[list[Any]]) -> type[Any]:
    """Stands for a dataclass: the same fields and defaults, of any type."""
    made: list[tuple[str, Any, Any]] = []
    for field_name, *default in described[:MOST]:
        made.append((field_name, Any, _default_of(default[0]) if default else field(kw_only=True)))
    return make_dataclass(str(name), made, frozen=True)


def _default_of(encoded: Any) -> Any:
    return field(default_factory=lambda: decode(encoded))
