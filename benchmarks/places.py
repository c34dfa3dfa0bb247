"""Places for benchmarks: what local exploration would sample beside corners, pillars and thin walls.

The places lie in small rooms of their own, one a seed. Positions and views are taken where a robot of the
e-puck's width can drive, in the order in which it would, without the physics: seconds instead of minutes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tolman.world import Pose, World, WorldSpec, open_world
from tolman.world.geometry import Plan, cast
from tolman.world.robot import EPUCK
from tolman.world.spec import Cylinder, Shape, Start, Wall

KINDS = ("corner", "thin wall", "block", "pillar", "two thin walls")
ROOM = 0.8
SPACING, STEP, VIEW_EVERY = 0.05, 0.02, 2
"""Meters between the places of the rigid graph and between samples; samples a view."""

NOISE = 0.002
"""Standard deviation (m) of where the robot believes a sample was taken."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlaceSamples:
    """What was sampled around one place. positions: (n, 2) m, views: (k, 4, 16, 16) at (k, 2) m; room frame.

    plan: of what stands in the room. kind: one of KINDS.
    """

    kind: str
    center: tuple[float, float]
    positions: Floats
    view_positions: Floats
    views: Floats
    plan: Plan

    def local(self, positions: Floats) -> Floats:
        """Positions (n, 2) m around the place."""
        return np.asarray(positions - np.array(self.center))


def sample_place(seed: int) -> PlaceSamples:
    """The place of a seed; equal seeds give equal samples."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 4]))
    kind = KINDS[seed % len(KINDS)]
    x, y = (float(value) for value in 0.4 + rng.uniform(-0.02, 0.02, 2))
    feature = _feature(kind, x, y, rng)
    spec = WorldSpec(f"place{seed}", (*_walls(), *feature), (Start("right", Pose(0.1, 0.1, 0.0)),))
    world = open_world(spec, engine="kinematic", noise="none", seed=seed)
    try:
        places = np.array(list(_drive(world, x, y)))
        spots = places[::VIEW_EVERY]
        views = np.array([_panorama(world, float(a), float(b)) for a, b in spots])
    finally:
        world.close()
    believed = places + rng.normal(0.0, NOISE, places.shape)
    return PlaceSamples(kind, (x, y), believed, believed[::VIEW_EVERY], views, Plan(spec.shapes))


def _walls() -> tuple[Wall, ...]:
    corners = [(0.0, 0.0), (ROOM, 0.0), (ROOM, ROOM), (0.0, ROOM)]
    return tuple(Wall(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))


def _feature(kind: str, x: float, y: float, rng: np.random.Generator) -> tuple[Shape, ...]:
    """What stands about a body's width from x, y (m)."""
    angle = float(rng.uniform(-math.pi, math.pi))
    away = EPUCK.body_radius + float(rng.uniform(0.015, 0.025))
    ahead, aside = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))

    def at(forward: float, left: float) -> tuple[float, float]:
        return x + forward * ahead[0] + left * aside[0], y + forward * ahead[1] + left * aside[1]

    if kind == "corner":
        return Wall(at(-0.3, away), at(away, away)), Wall(at(away, away), at(away, -0.3))
    if kind == "thin wall":
        return (Wall(at(-0.02, away), at(-0.35, away), 0.005),)
    if kind == "block":
        return (Wall(at(0.0, away + 0.05), at(0.3, away + 0.05), 0.1),)
    if kind == "pillar":
        return (Cylinder(*at(0.0, away + 0.03), 0.03),)
    return Wall(at(-0.02, away), at(-0.35, away), 0.005), Wall(at(0.02, -away), at(0.35, -away), 0.005)


def _drive(world: World, x: float, y: float) -> Iterator[tuple[float, float]]:
    """Positions (m) every STEP along the rigid graph's edges, depth first, where the body fits through."""
    reach = 2
    seen, way = {(0, 0)}, [(0, 0)]
    yield x, y
    while way:
        here = way[-1]
        for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            there = here[0] + step[0], here[1] + step[1]
            if there in seen or max(abs(there[0]), abs(there[1])) > reach:
                continue
            leg = [
                (x + (here[0] + share * step[0]) * SPACING, y + (here[1] + share * step[1]) * SPACING)
                for share in np.linspace(0.0, 1.0, 1 + math.ceil(SPACING / STEP))
            ]
            if all(world.clearance(*place) > EPUCK.body_radius + 0.001 for place in leg):
                seen.add(there)
                way.append(there)
                yield from leg[1:]
                break
        else:
            way.pop()


def _panorama(world: World, x: float, y: float) -> Floats:
    """(4, 16, 16) views ahead, left, behind, right, heading 0."""
    views = []
    for quarter in range(4):
        world.place(Pose(x, y, quarter * math.pi / 2.0))
        views.append(world.robots[0].look())
    return np.array(views, dtype=np.float64)


def crosses(plan: Plan, start: Floats, end: Floats) -> bool:
    """Whether the segment from start to end, (2,) m, crosses a wall."""
    away = end - start
    length = float(np.hypot(*away))
    return bool(cast(start[None], away[None] / length, plan.segments)[0] < length)
