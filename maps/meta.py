"""What a map says about itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from .errors import MapError, some

Scalar = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class MapMeta:
    """Where a map comes from and where its robot stands. No times, hosts or paths: same run, same bytes.

    world, world_digest: the world's name and the hash of its definition. side: the side mapped with, `right`
    or `left`. versions: name -> version of what made it. geometry: the robot's name. loop_closed: whether the
    mapping met its first node again. current_node, arrival: the node the robot is at, and the kind of the arc
    it came by (None: it never moved). scalars: anything else, JSON scalars by name.
    """

    world: str = ""
    world_digest: str = ""
    profile: str = "default"
    side: str = "right"
    seed: int = 0
    noise: str = "thesis"
    versions: Mapping[str, str] = field(default_factory=dict)
    geometry: str = "e-puck"
    loop_closed: bool = False
    current_node: int | None = None
    arrival: str | None = None
    scalars: Mapping[str, Scalar] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Checks the types. Raises: MapError."""
        for name, kinds in _TYPES.items():
            value = getattr(self, name)
            if not isinstance(value, kinds) or (kinds is not bool and isinstance(value, bool)):
                raise MapError(f"meta {name} = {value!r}: expected {_spell(kinds)}")
        for key, version in self.versions.items():
            if not isinstance(key, str) or not isinstance(version, str):
                raise MapError(f"meta versions: {key!r}: {version!r} must both be strings")
        for key, value in self.scalars.items():
            if not isinstance(key, str) or not is_scalar(value):
                raise MapError(f"meta scalars: {key!r}: {value!r} must be a string and a finite JSON scalar")

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values by field name."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {**values, "versions": dict(self.versions), "scalars": dict(self.scalars)}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> MapMeta:
        """The inverse of `to_json`. Raises: MapError for unknown or missing names and wrong types."""
        known = {entry.name for entry in fields(cls)}
        if set(values) != known:
            raise MapError(f"meta fields must be exactly: {some(sorted(known), 20)}")
        return cls(**values)


_TYPES: dict[str, Any] = {
    "world": str,
    "world_digest": str,
    "profile": str,
    "side": str,
    "seed": int,
    "noise": str,
    "versions": Mapping,
    "geometry": str,
    "loop_closed": bool,
    "current_node": (int, type(None)),
    "arrival": (str, type(None)),
    "scalars": Mapping,
}


def _spell(kinds: Any) -> str:
    return " or ".join(kind.__name__ for kind in (kinds if isinstance(kinds, tuple) else (kinds,)))


def is_scalar(value: object) -> bool:
    """Whether a value is a JSON scalar that round-trips: str, bool, None, finite float, 64-bit int."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return True
    if isinstance(value, int):
        return -(2**63) <= value < 2**63
    return isinstance(value, float) and math.isfinite(value)
