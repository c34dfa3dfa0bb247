"""Puts an agent together: behaviors by entry point, settings from a file, the mediator."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...agent import Agent
from ...agent.handle import Limits
from ...plugins.discovery import build_behaviors, load_mediator
from ...world import World, WorldSpec, open_world
from ...world.robot import Pose
from .profiles import Profile, behavior_settings, find_profile
from .requests import SessionError, Simulation

CONFIG_LIMIT = 1 << 20
HANG = 2.0
"""Wall-clock seconds after which a behavior is interrupted where plugins from folders are loaded."""
_SECTIONS = ("behaviors", "mapping", "mediator", "noise")


def load_settings(path: Path | None) -> dict[str, Any]:
    """The settings of a YAML file: sections behaviors, mapping, mediator, noise. Raises: SessionError."""
    if path is None:
        return {}
    import yaml

    try:
        if path.stat().st_size > CONFIG_LIMIT:
            raise SessionError(f"{path}: larger than {CONFIG_LIMIT} bytes, too large for settings")
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SessionError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise SessionError(f"{path}: expected sections such as `behaviors:`, found a {type(values).__name__}")
    for name in values:
        if name not in _SECTIONS:
            raise SessionError(f"{path}: unknown section {name!r}; known: {', '.join(_SECTIONS)}")
    return values


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
    mediator = load_mediator(settings.get("mediator", "priority"), simulation.plugins)
    limits = Limits(hang=HANG) if simulation.plugins else Limits(budget=None)
    seed = np.random.SeedSequence([simulation.seed, robot])
    agent = Agent(world.robots[robot], behaviors.values(), mediator=mediator, seed=seed, limits=limits)
    for name in profile.reflexes:
        agent.start(name)
    return agent
