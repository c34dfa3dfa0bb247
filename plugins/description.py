"""What people want to know of a behavior, as JSON values: its machine, its settings, what it is for."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from ..agent.behavior import Behavior
from .diagram import edges


def described(behavior: Behavior) -> dict[str, Any]:
    """Name, priority, purpose, settings in force, states, the first, `[source, target, triggers]`."""
    cls, config = type(behavior), behavior.config
    settings = fields(config) if is_dataclass(config) and not isinstance(config, type) else ()
    return {
        "name": behavior.name,
        "priority": behavior.priority,
        "about": (cls.__doc__ or "").strip().split("\n\n")[0],
        "settings": {each.name: _plain(getattr(config, each.name)) for each in settings},
        "states": [state.name for state in cls.States],
        "initial": cls.initial.name,
        "edges": [[a.name, b.name, ", ".join(triggers)] for (a, b), triggers in edges(cls).items()],
        "children": {
            child.name: described(child) for child in (getattr(behavior, role) for role in cls.children)
        },
    }


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return float(f"{value:.6g}") if abs(value) < 1e300 else str(value)
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    return str(value)
