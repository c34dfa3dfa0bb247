"""Profiles as data: which behaviors with which settings, which mapper, which navigator, which local maps.

`thesis` is the published method, faults included (decision records 060 to 062); `default` is ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal

from ...agent.boundary.trace import ClosingConfig
from ...maps.local.config import DEFAULT, THESIS_2, LocalMapConfig
from ...maps.som.schedules import PERCEPTUAL_2
from ..errors import SessionError, did_you_mean

Settings = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Profile:
    """One method of mapping and navigating.

    behaviors: settings by behavior, other than their defaults. mapper: nodes at corners of the boundary
    ("corners"), or by algorithm 1 ("turns"). navigator: arcs end at recognized corners ("corners"), or after
    their straight-line distance ("distance"). local_map: how local maps are trained. closing: threshold of
    eq. 3.33 in D_a ("turns" only). correct: whether the position is corrected by views at each node
    ("distance" only). max_nodes: limit of a mapping where none is asked for. reflexes: behaviors that are
    active from the first tick on. mapping: settings of the mapper, other than its defaults. learn_mismatch:
    whether the wheels' mismatch is learned along walls ("corners" only).
    """

    name: str
    behaviors: Settings = field(default_factory=lambda: MappingProxyType({}))
    mapper: Literal["corners", "turns"] = "corners"
    navigator: Literal["corners", "distance"] = "corners"
    local_map: LocalMapConfig = DEFAULT
    closing: float | None = None
    correct: bool = False
    max_nodes: int | None = None
    reflexes: tuple[str, ...] = ()
    mapping: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    learn_mismatch: bool = True

    def behavior_settings(self, asked: Settings | None) -> dict[str, dict[str, Any]]:
        """The profile's settings of behaviors, with those asked for on top."""
        merged = {name: dict(values) for name, values in self.behaviors.items()}
        for name, values in (asked or {}).items():
            merged.setdefault(name, {}).update(values)
        return merged


THESIS_LOCAL_MAP = replace(THESIS_2, perceptual=replace(PERCEPTUAL_2, max_steps=1444, radius_end=1.5))
"""Configuration 2, stopped after the published mean number of steps; its last radius, which is not published,
chosen so that D_a lets eq. 3.33 close about as often as published (decision record 062)."""

PROFILES: Mapping[str, Profile] = MappingProxyType(
    {
        "default": Profile(
            "default",
            # Nearer than what local exploration stops for by itself, or the two would take turns for ever.
            behaviors=MappingProxyType(
                {"obstacle-avoidance": MappingProxyType({"front": 0.004, "diagonal": 0.004})}
            ),
            reflexes=("free-itself", "obstacle-avoidance"),
        ),
        "thesis": Profile(
            "thesis",
            behaviors=MappingProxyType(
                {
                    "local-exploration": MappingProxyType(
                        {
                            "landmarks": False,
                            "compass": False,
                            "panorama_interval": 0.04,
                            "turn_speed": 300.0,
                        }
                    ),
                    "local-go-to": MappingProxyType({"turn_speed": 233.0}),
                }
            ),
            mapper="turns",
            navigator="distance",
            local_map=THESIS_LOCAL_MAP,
            closing=1.0,
            correct=True,
            max_nodes=120,
        ),
    }
)
"""The profiles there are, by name."""


WITHOUT = " without "


def _set(behavior: str, **values: Any) -> Callable[[Profile], Profile]:
    def change(profile: Profile) -> Profile:
        return replace(profile, behaviors=profile.behavior_settings({behavior: values}))

    return change


REMEDIES: Mapping[str, Callable[[Profile], Profile]] = MappingProxyType(
    {
        "recognized corners": _set("go-to-node", recognize=False),
        "mismatch": lambda profile: replace(
            profile, learn_mismatch=False, mapping={**profile.mapping, "learn_mismatch": False}
        ),
        "landmarks": _set("local-exploration", landmarks=False),
        "compass": _set("local-exploration", compass=False),
        "coming back": lambda profile: replace(profile, mapping={**profile.mapping, "come_back": False}),
        "square rooms": lambda profile: replace(
            profile, mapping={**profile.mapping, "closing": ClosingConfig(square_limit=0.0)}
        ),
        "confirmation": lambda profile: replace(
            profile, mapping={**profile.mapping, "closing": ClosingConfig(confirmations=0)}
        ),
        "reflexes": lambda profile: replace(profile, reflexes=()),
    }
)
"""What profile `default` has against error, each as the change that takes it away: for ablations.

Arcs ended at recognized corners (else after their path length); the wheels' mismatch learned; walls as
landmarks and the visual compass in local exploration; the corner come back to after exploring; right angles
taken for exact where a room has no others; a closed loop confirmed at the next corners; reflexes.
"""


def find_profile(name: str) -> Profile:
    """The profile of that name, or, as in "default without compass", one of them without a remedy.

    Raises: SessionError, naming those there are.
    """
    base, without, remedy = name.partition(WITHOUT)
    if without and base in PROFILES and remedy in REMEDIES:
        return replace(REMEDIES[remedy](PROFILES[base]), name=name)
    try:
        return PROFILES[name]
    except KeyError:
        known = ", ".join(PROFILES)
        raise SessionError(
            f"unknown profile {name!r}{did_you_mean(name, PROFILES)} (profiles: {known})"
        ) from None
