"""Opening a world: the one entry point for all who simulate."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .arenas.catalog import find_world
from .base import World
from .errors import WorldError
from .noise.model import Noise, resolve_noise
from .robot import EPUCK, Pose, RobotGeometry
from .sensors.sensor import Timing
from .spec import WorldSpec

MODELS = ("wheels", "planar")
ENGINES = ("dart", "kinematic")
ENGINES_OF_RAYS = ("auto", "embree", "numpy")


def open_world(
    world: str | Path | WorldSpec,
    *,
    seed: int = 0,
    noise: str | Noise | Mapping[str, float | str] = "thesis",
    noise_scale: float = 1.0,
    model: str = "wheels",
    engine: str = "dart",
    start: Pose | str | None = None,
    geometry: RobotGeometry = EPUCK,
    rays: str = "auto",
    sensing: Mapping[str, Timing | Mapping[str, Any]] | None = None,
    scale: float = 1.0,
) -> World:
    """A world ready to step, its first robot at `start`: a pose, a start's name, or None for the first start.

    world: a built-in name, the path of a world file, or a description. model: "wheels" or "planar" (DART);
    engine: "dart" or "kinematic". noise: a preset, values, or a mapping of values. sensing: delays and
    intervals of sensors by name; a name that `geometry` does not list adds that sensor. rays: "auto",
    "embree" or "numpy" (see `rays.make_caster`). scale: what the lengths of a world from a file are
    multiplied by.

    Raises: WorldError and its kinds, one line each: unknown world, model, engine, noise; bad file, start.
    """
    spec = world if isinstance(world, WorldSpec) else find_world(world, scale)
    starts = (_start_pose(spec, start), *spec.robots)
    values = resolve_noise(noise, noise_scale)
    if model not in MODELS:
        raise WorldError(f"unknown robot model {model!r}; known: {', '.join(MODELS)}")
    if rays not in ENGINES_OF_RAYS:
        raise WorldError(f"unknown ray engine {rays!r}; known: {', '.join(ENGINES_OF_RAYS)}")
    if engine not in ENGINES:
        raise WorldError(f"unknown engine {engine!r}; known: {', '.join(ENGINES)}")
    from .sensors.registry import fitted  # here, as the rest: who only names or describes worlds needs none

    options: dict[str, Any] = {
        "seed": seed,
        "noise": values,
        "sensors": fitted(geometry, sensing),
        "geometry": geometry,
        "rays": rays,
    }
    if engine == "kinematic":
        from .physics.kinematic import KinematicWorld

        return KinematicWorld(spec, starts, **options)
    from .physics.dart import DartWorld

    return DartWorld(spec, starts, model=model, **options)


def _start_pose(spec: WorldSpec, start: Pose | str | None) -> Pose:
    if isinstance(start, Pose):
        return start
    if start is not None:
        return spec.start(start)
    if not spec.starts:
        raise WorldError(f"world {spec.name!r} names no start; give one: x, y in meters and a heading")
    return spec.starts[0].pose
