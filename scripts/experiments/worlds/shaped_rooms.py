"""Rooms of other shapes than right-angled ones, from a seed: slanted walls, round ones, narrow passages."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ....world.errors import WorldError
from ....world.geometry import Plan, Point
from ....world.spec import Box, Cylinder, Shape, Wall, WorldSpec, room_walls
from ....world.starts import with_starts

LEAST_GAP = 0.24
"""Meters: the narrowest passage of a slanted or round room."""
NARROW = (0.10, 0.14)
"""Meters: how wide the passage of a narrow room is."""
_LEAST_WALL = 0.2
_LEAST_TURN, _MOST_TURN = math.radians(25.0), math.radians(125.0)
"""How far a slanted room turns at a corner (rad): less is a bend, more too sharp an angle to drive into."""
_TRIES = 2000
_THICK = 0.02


def shaped_room(kind: str, seed: int) -> WorldSpec:
    """The room of a kind (key of `SHAPES`) and a seed. Everything hangs together with the outer wall."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 29, list(SHAPES).index(kind)]))
    for _ in range(_TRIES):
        shapes = SHAPES[kind](rng)
        if shapes is None:
            continue
        spec = with_starts(WorldSpec(f"{kind} {seed}", tuple(shapes), description="drawn from a seed"))
        if spec.starts:
            return spec
    raise WorldError(f"no {kind} room for seed {seed} in {_TRIES} tries")


def _slanted(rng: np.random.Generator) -> list[Shape] | None:
    """Five to nine walls around a middle, at any angle; corners lead in and out."""
    count = int(rng.integers(5, 10))
    turns = np.sort(rng.uniform(0.0, math.tau, count))
    reach = rng.uniform(0.45, 0.9, count)
    points = [(float(r * math.cos(t)), float(r * math.sin(t))) for r, t in zip(reach, turns, strict=True)]
    if not _well_shaped(points):
        return None
    return [Wall(a, b, _THICK) for a, b in zip(points, [*points[1:], points[0]], strict=True)]


def _well_shaped(points: list[Point]) -> bool:
    count = len(points)
    for k in range(count):
        before, here, after = points[k - 1], points[k], points[(k + 1) % count]
        turn = _heading(here, after) - _heading(before, here)
        turn = abs(math.remainder(turn, math.tau))
        if math.dist(here, after) < _LEAST_WALL or not _LEAST_TURN < turn < _MOST_TURN:
            return False
        others = [
            Wall(points[i], points[(i + 1) % count], _THICK)
            for i in range(count)
            if i not in (k, (k + 1) % count, (k - 1) % count)
        ]
        middle = ((here[0] + after[0]) / 2, (here[1] + after[1]) / 2)
        if any(Plan((wall,)).clearance(*place) < LEAST_GAP for wall in others for place in (here, middle)):
            return False
    return True


def _heading(one: Point, other: Point) -> float:
    return math.atan2(other[1] - one[1], other[0] - one[0])


def _round(rng: np.random.Generator) -> list[Shape] | None:
    """A rectangular room with pillars that stand half in its walls, and perhaps one in a corner."""
    width, depth = (float(rng.uniform(1.0, 1.5)) for _ in range(2))
    pillars: list[Cylinder] = []
    if rng.random() < 0.5:
        pillars.append(Cylinder(width, depth, float(rng.uniform(0.15, 0.3))))
    for _ in range(int(rng.integers(2, 5))):
        radius = float(rng.uniform(0.06, 0.22))
        along = float(rng.uniform(0.0, 1.0))
        x, y = [(along * width, 0.0), (along * width, depth), (0.0, along * depth), (width, along * depth)][
            int(rng.integers(4))
        ]
        pillar = Cylinder(x, y, radius)
        if _has_room(pillar, pillars, width, depth):
            pillars.append(pillar)
    return [*room_walls(width, depth), *pillars] if len(pillars) > 1 else None


def _has_room(pillar: Cylinder, others: list[Cylinder], width: float, depth: float) -> bool:
    at = (pillar.x, pillar.y)
    corners = [(x, y) for x in (0.0, width) for y in (0.0, depth)]
    if any(math.dist(at, corner) < pillar.radius + LEAST_GAP for corner in corners):
        return False
    return all(
        math.dist(at, (other.x, other.y)) > pillar.radius + other.radius + LEAST_GAP for other in others
    )


def _narrow(rng: np.random.Generator) -> list[Shape] | None:
    """A room in two parts; a block leaves a passage between them that is hardly wider than the robot."""
    width, depth = (float(rng.uniform(0.9, 1.4)) for _ in range(2))
    gap, thick = float(rng.uniform(*NARROW)), float(rng.uniform(0.1, 0.3))
    middle = float(rng.uniform(0.35, 0.65)) * width
    block = Box(middle, 0.5 * (depth - gap), thick, depth - gap)
    nook = Box(0.0, 0.0, float(rng.uniform(0.36, 0.44)), float(rng.uniform(0.36, 0.6)))
    return [*room_walls(width, depth), block, nook] if middle - 0.5 * thick > 0.25 + nook.width / 2 else None


SHAPES: Mapping[str, Callable[[np.random.Generator], list[Shape] | None]] = MappingProxyType(
    {"slanted": _slanted, "round": _round, "narrow": _narrow}
)
"""What is drawn, by name; None where the numbers drawn make no room."""
