"""Rooms full of what is hard to follow: posts near one another, wedges, stubs of thin walls, narrow gaps."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..geometry import Plan, Point
from ..spec import Box, Cylinder, Polygon, Shape, Wall, WorldSpec, room_walls
from ..starts import with_starts


def room(rng: np.random.Generator) -> WorldSpec:
    """A rectangular room with four to eight of these things at its walls, and some standing free."""
    while True:
        width, depth = (float(size) for size in rng.uniform(1.1, 1.8, 2))
        shapes: list[Shape] = [*room_walls(width, depth)]
        for _ in range(int(rng.integers(4, 9))):
            place, inward = _at_wall(width, depth, rng)
            thing = _THINGS[int(rng.integers(len(_THINGS)))](place, inward, rng)
            if Plan(tuple(shapes[4:])).clearance(*place) > 0.25 if len(shapes) > 4 else True:
                shapes += thing
        spec = with_starts(WorldSpec("clutter", tuple(shapes), description="a room full of small things"))
        if spec.starts and len(shapes) > 7:
            return spec


def _at_wall(width: float, depth: float, rng: np.random.Generator) -> tuple[Point, float]:
    """A place on a wall, away from corners, and the direction (rad) into the room."""
    side = int(rng.integers(4))
    along = float(rng.uniform(0.18, (width if side % 2 == 0 else depth) - 0.18))
    places: list[tuple[Point, float]] = [
        ((along, 0.0), 0.5 * math.pi),
        ((width, along), math.pi),
        ((along, depth), -0.5 * math.pi),
        ((0.0, along), 0.0),
    ]
    return places[side]


def _from(place: Point, direction: float, ahead: float, left: float = 0.0) -> Point:
    cosine, sine = math.cos(direction), math.sin(direction)
    return place[0] + ahead * cosine - left * sine, place[1] + ahead * sine + left * cosine


def _stub(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """A thin wall that ends in the room."""
    end = _from(place, inward + float(rng.uniform(-0.3, 0.3)), float(rng.uniform(0.1, 0.35)))
    return [Wall(place, end, float(rng.uniform(0.006, 0.02)))]


def _wedge(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """A triangle with its tip in the room."""
    half, out = float(rng.uniform(0.02, 0.1)), float(rng.uniform(0.08, 0.25))
    tip = _from(place, inward, out, float(rng.uniform(-0.08, 0.08)))
    return [Polygon((_from(place, inward, 0.0, -half), tip, _from(place, inward, 0.0, half)))]


def _posts(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """Two to four posts a few centimeters apart, the first at the wall."""
    step, size = float(rng.uniform(0.03, 0.09)), float(rng.uniform(0.01, 0.03))
    lean = float(rng.uniform(-0.5, 0.5))
    return [
        Box(*_from(place, inward + lean, 0.5 * size + index * (size + step)), size, size, inward + lean)
        for index in range(int(rng.integers(2, 5)))
    ]


def _gap(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """Two blocks with a gap too narrow to pass between them."""
    gap, deep = float(rng.uniform(0.02, 0.065)), float(rng.uniform(0.08, 0.2))
    wide = float(rng.uniform(0.05, 0.12))
    offsets = (0.5 * (gap + wide), -0.5 * (gap + wide))
    return [Box(*_from(place, inward, 0.5 * deep, left), deep, wide, inward) for left in offsets]


def _table(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """Four legs of a table that stands near the wall."""
    side, leg = float(rng.uniform(0.14, 0.3)), float(rng.uniform(0.006, 0.014))
    off = float(rng.uniform(0.1, 0.2))
    return [
        Cylinder(*_from(place, inward, off + ahead * side, (left - 0.5) * side), leg)
        for ahead in (0.0, 1.0)
        for left in (0.0, 1.0)
    ]


def _bump(place: Point, inward: float, rng: np.random.Generator) -> list[Shape]:
    """A round thing at the wall, flat or deep."""
    radius = float(rng.uniform(0.03, 0.1))
    return [Cylinder(*_from(place, inward, float(rng.uniform(-0.5, 0.8)) * radius), radius)]


_THINGS: tuple[Callable[[Point, float, np.random.Generator], list[Shape]], ...] = (
    _stub,
    _wedge,
    _posts,
    _gap,
    _table,
    _bump,
)
