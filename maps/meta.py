"""What a map says about itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from .errors import MapError, some
from .fields import SIDES, Field, Record, Scalar, declared, number

_TEXT = Field("text")


@dataclass(frozen=True, slots=True)
class MapMeta:
    """Where a map comes from and where its robot stands. No times, hosts or paths: same run, same bytes.

    world, world_digest: the world's name and the hash of its definition. side: the side mapped with, `right`
    or `left`. versions: name -> version of what made it. geometry: the robot's name. loop_closed: whether the
    mapping met its first node again. current_node, arrival: the node the robot is at, and the kind of the arc
    it came by (None: it never moved). scalars: anything else, JSON scalars by name.
    """

    world: Annotated[str, _TEXT] = ""
    world_digest: Annotated[str, _TEXT] = ""
    profile: Annotated[str, _TEXT] = "default"
    side: Annotated[str, Field("text", choices=SIDES)] = "right"
    seed: Annotated[int, Field("integer")] = 0
    noise: Annotated[str, _TEXT] = "thesis"
    versions: Annotated[Mapping[str, str], Field("texts")] = field(default_factory=dict)
    geometry: Annotated[str, _TEXT] = "e-puck"
    loop_closed: Annotated[bool, Field("flag")] = False
    current_node: Annotated[int | None, number("", empty=True)] = None
    arrival: Annotated[str | None, Field("text", empty=True)] = None
    scalars: Annotated[Mapping[str, Scalar], Field("scalars")] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Checks the types. Raises: MapError."""
        try:
            META.clean((), {name: getattr(self, name) for name in META.by_name})
        except ValueError as error:
            raise MapError(str(error)) from None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values by field name."""
        values = {name: getattr(self, name) for name in META.by_name}
        return {**values, "versions": dict(self.versions), "scalars": dict(self.scalars)}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> MapMeta:
        """The inverse of `to_json`. Raises: MapError for unknown or missing names and wrong types."""
        if set(values) != set(META.by_name):
            raise MapError(f"meta fields must be exactly: {some(sorted(META.by_name), 20)}")
        return cls(**values)


META = Record("meta", (), declared(MapMeta))
