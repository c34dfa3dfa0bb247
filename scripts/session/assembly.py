"""Puts together what a run needs, as its settings and its profile say: world, agents, mappers, navigators."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...agent import Agent, Behavior
from ...agent.handle import Limits
from ...agent.islands.mapper import IslandMapper
from ...agent.mapping.corners import Mapper, MappingConfig
from ...agent.mapping.published import ThesisMapper, ThesisMappingConfig
from ...agent.navigation.corners import Navigator
from ...agent.navigation.published import ThesisNavigationConfig, ThesisNavigator
from ...plugins.discovery import Catalog, apart, build_behaviors, discover
from ...plugins.loading import HANG
from ...world import World, WorldSpec, open_world
from ...world.link.model import find_timings
from ...world.link.opening import behind_link, connect
from ...world.link.units import E_PUCK2
from ...world.robot import EPUCK, Pose, Robot
from ..errors import SessionError

if TYPE_CHECKING:
    from ...agent import Mediator
    from ...agent.mapping.base import AnyMapper, MapSink
    from ...agent.navigation.base import BaseNavigator
    from ...maps.hybrid_map import HybridMap
    from .profiles import Profile
    from .requests import MapRequest, RunSettings


def find_plugins(
    settings: RunSettings, profile: Profile, configs: Mapping[str, Mapping[str, Any]] | None
) -> Catalog:
    """The plugins that a run may use: what is isolated is never imported here. Raises: PluginError."""
    return discover(settings.plugins, apart(profile.behavior_settings(configs), settings.isolate))


def make_world(
    settings: RunSettings, world: str | WorldSpec, noise_values: Mapping[str, Any], start: Pose | str | None
) -> World:
    """Opens a world (name, path, description) with a run's noise and robot model. Raises: WorldError.

    noise_values: values on top of the preset that the settings name. With a robot's address in the settings
    nothing is simulated, and `world` is what the robot's surroundings are called.
    """
    if settings.robot is not None:
        place = world if isinstance(world, str) else world.name
        return connect(settings.robot, place, settings.seed, settings.calibration)
    noise: Any = {"preset": settings.noise, **noise_values} if noise_values else settings.noise
    if settings.link is not None:
        find_timings(settings.link)
    opened = open_world(
        world,
        seed=settings.seed,
        noise=noise,
        noise_scale=settings.noise_scale,
        model=settings.model,
        engine=settings.engine,
        start=start,
        scale=settings.scale,
        geometry=EPUCK if settings.link is None else E_PUCK2,
    )
    if settings.link is None:
        return opened
    return behind_link(opened, settings.link, settings.seed, settings.calibration)


def make_agent(
    settings: RunSettings,
    profile: Profile,
    configs: Mapping[str, Mapping[str, Any]] | None,
    catalog: Catalog,
    mediator: Mediator,
    robot: Robot,
    index: int = 0,
    others: Iterable[Behavior] = (),
) -> Agent:
    """An agent for a robot, with every behavior that is found and the profile's reflexes at work.

    configs: settings by behavior, on top of the profile's. catalog: by `find_plugins`.
    index: of the robot in its world. others: behaviors besides those that are found.

    Behaviors from folders run under the default limits; without them nothing depends on the wall clock.
    Raises: PluginError, ConfigError.
    """
    merged = profile.behavior_settings(configs)
    behaviors = build_behaviors(None, catalog, merged)
    limits = Limits(hang=HANG) if settings.plugins else Limits(budget=None)
    seed = np.random.SeedSequence([settings.seed, index])
    every = [*behaviors.values(), *others]
    agent = Agent(robot, every, mediator=mediator, seed=seed, limits=limits)
    for name in profile.reflexes:
        agent.start(name)
    return agent


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
