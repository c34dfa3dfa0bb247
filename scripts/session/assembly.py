"""Puts an agent together: behaviors by entry point, settings from a file, the mediator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...agent import Agent
from ...agent.handle import Limits
from ...plugins.discovery import build_behaviors, load_mediator
from ...world import World, WorldSpec, open_world
from ...world.robot import Pose
from .profiles import Profile, behavior_settings, find_profile
from .requests import Simulation
from .settings import mediator_of

HANG = 2.0
"""Wall-clock seconds after which a behavior is interrupted where plugins from folders are loaded."""


def make_world(
    simulation: Simulation, world: str | WorldSpec, settings: Mapping[str, Any], start: Pose | str | None
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
    simulation: Simulation,
    world: World,
    settings: Mapping[str, Any],
    robot: int = 0,
    profile: Profile | None = None,
) -> Agent:
    """An agent for one of the world's robots, with every behavior that is found and the reflexes at work.

    profile: None is the one that the simulation names.

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
    agent = Agent(world.robots[robot], behaviors.values(), mediator=mediator, seed=seed, limits=limits)
    for name in profile.reflexes:
        agent.start(name)
    return agent
