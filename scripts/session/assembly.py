"""Puts an agent together: behaviors by entry point, settings from a file, the mediator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...agent import Agent, Behavior
from ...agent.handle import Limits
from ...plugins.discovery import build_behaviors, load_mediator
from ...world import World, WorldSpec, open_world
from ...world.robot import Pose
from .profiles import Profile, behavior_settings, find_profile
from .requests import RunSettings
from .settings import mediator_of

HANG = 2.0
"""Wall-clock seconds after which a behavior is interrupted where plugins from folders are loaded."""


def make_world(
    simulation: RunSettings, world: str | WorldSpec, settings: Mapping[str, Any], start: Pose | str | None
) -> World:
    """Opens a world (name, path, description) with a request's noise and robot model. Raises: WorldError."""
    noise: Any = simulation.noise
    if "noise" in settings:
        noise = {"preset": simulation.noise, **settings["noise"]}
    return open_world(
        world,
        seed=simulation.seed,
        noise=noise,
        noise_scale=simulation.noise_scale,
        model=simulation.model,
        engine=simulation.engine,
        start=start,
        scale=simulation.scale,
    )


def make_agent(
    simulation: RunSettings,
    world: World,
    settings: Mapping[str, Any],
    robot: int = 0,
    profile: Profile | None = None,
    others: Iterable[Behavior] = (),
) -> Agent:
    """An agent for one of the world's robots, with every behavior that is found and the reflexes at work.

    profile: None is the one that the simulation names. others: behaviors besides those that are found.

    Behaviors from folders run under the default limits; without them nothing depends on the wall clock.
    Raises: PluginError, ConfigError, SessionError.
    """
    profile = profile or find_profile(simulation.profile)
    configs = behavior_settings(profile, settings.get("behaviors"))
    behaviors = build_behaviors(None, simulation.plugins, configs, isolate=simulation.isolate)
    name, options = mediator_of(settings)
    mediator = load_mediator(name, simulation.plugins, options)
    limits = Limits(hang=HANG) if simulation.plugins else Limits(budget=None)
    seed = np.random.SeedSequence([simulation.seed, robot])
    every = [*behaviors.values(), *others]
    agent = Agent(world.robots[robot], every, mediator=mediator, seed=seed, limits=limits)
    for name in profile.reflexes:
        agent.start(name)
    return agent
