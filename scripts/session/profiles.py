"""Profiles as data: which behaviors with which settings, which mapper, which navigator, which local maps.

`thesis` is the published method, faults included (decision records 060 to 062); `default` is ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal

from ...agent import Agent
from ...agent.boundary.trace import ClosingConfig
from ...agent.islands.mapper import IslandMapper
from ...agent.mapping.base import AnyMapper, MapSink
from ...agent.mapping.corners import Mapper, MappingConfig
from ...agent.mapping.published import ThesisMapper, ThesisMappingConfig
from ...agent.navigation.base import BaseNavigator
from ...agent.navigation.corners import Navigator
from ...agent.navigation.published import ThesisNavigationConfig, ThesisNavigator
from ...maps.hybrid_map import HybridMap
from ...maps.local.training import DEFAULT, THESIS_2, LocalMapConfig
from ...maps.som.schedules import PERCEPTUAL_2
from ..errors import did_you_mean
from .requests import MapRequest, SessionError
from .settings import updated_fields

Settings = Mapping[str, Mapping[str, Any]]
_FROM_REQUEST = ("side", "local_maps", "strategy", "max_nodes")
"""Fields of a mapper's settings that a request sets, and a file of settings cannot."""


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
        return replace(profile, behaviors=behavior_settings(profile, {behavior: values}))

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


def behavior_settings(profile: Profile, asked: Settings | None) -> dict[str, dict[str, Any]]:
    """The profile's settings of behaviors, with those asked for on top."""
    merged = {name: dict(values) for name, values in profile.behaviors.items()}
    for name, values in (asked or {}).items():
        merged.setdefault(name, {}).update(values)
    return merged


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


def make_mapper(
    profile: Profile,
    request: MapRequest,
    agent: Agent,
    hybrid_map: HybridMap,
    sink: MapSink,
) -> AnyMapper:
    """The mapper that the profile names, set as the request asks.

    Raises: SessionError for islands with a profile that cannot map them.
    """
    limit = request.max_nodes if request.max_nodes is not None else profile.max_nodes
    local_maps = not request.global_only
    if request.islands and profile.mapper != "corners":
        raise SessionError(f"profile {profile.name!r} has no forays: --islands needs profile 'default'")
    if profile.mapper == "turns":
        published = ThesisMappingConfig(
            request.side, local_maps, request.strategy, limit, closing=profile.closing, **profile.mapping
        )
        return ThesisMapper(agent, hybrid_map, sink, published)
    config = MappingConfig(request.side, local_maps, request.strategy, limit, **profile.mapping)
    if request.islands:
        return IslandMapper(agent, hybrid_map, sink, config)
    return Mapper(agent, hybrid_map, sink, config)


def make_navigator(
    profile: Profile, agent: Agent, hybrid_map: HybridMap, node: int, arrival: str | None
) -> BaseNavigator:
    """The navigator that the profile names, for a robot at `node` that came by side `arrival`."""
    if profile.navigator == "distance":
        config = ThesisNavigationConfig(correct=profile.correct)
        return ThesisNavigator(agent, hybrid_map, node, arrival, config)
    return Navigator(agent, hybrid_map, node, arrival, learn_mismatch=profile.learn_mismatch)
