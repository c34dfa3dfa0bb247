"""Offices: rooms along corridors, with doors, desks and cupboards, at the scale of an e-puck."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..spec import Box, Shape, Wall, WorldSpec, room_walls
from ..starts import with_starts

_DOOR = (0.15, 0.24)
"""Meters: how wide doors are."""
_FREE = 0.14
"""Meters left free beside furniture, at least: twice the robot."""


@dataclass(frozen=True, slots=True)
class _Room:
    """A rectangle (m), and the line y of the wall that has its door."""

    x0: float
    y0: float
    x1: float
    y1: float
    door_y: float


def office(rng: np.random.Generator) -> WorldSpec:
    """Two rows of rooms along one corridor."""
    width = float(rng.uniform(1.8, 3.0))
    shapes, depth = _strip(width, 0.0, int(rng.integers(2, 4)), rng)
    return _finished([*room_walls(width, depth), *shapes], f"office, {width:.1f} x {depth:.1f} m")


def building(rng: np.random.Generator) -> WorldSpec:
    """Ten such offices above one another, each open to a passage along their left side."""
    width, passage = 4.2, float(rng.uniform(0.3, 0.4))
    shapes: list[Shape] = []
    y = 0.0
    for index in range(10):
        strip, depth = _strip(width, y, 5, rng, open_left=True)
        shapes += strip
        y += depth
        if index < 9:
            shapes.append(Wall((0.0, y), (width, y), 0.03))
    outer = [_moved(wall, -passage) for wall in room_walls(width + passage, y)]
    return _finished([*outer, *shapes], f"building, {width + passage:.1f} x {y:.1f} m, a hundred rooms")


def _strip(
    width: float, y: float, rooms: int, rng: np.random.Generator, open_left: bool = False
) -> tuple[list[Shape], float]:
    """Rooms on both sides of a corridor from x = 0 to `width`, beginning at `y`; and how deep that is (m)."""
    thickness = float(rng.uniform(0.015, 0.04))
    corridor = float(rng.uniform(0.26, 0.42))
    below, above = (float(rng.uniform(0.5, 0.9)) for _ in range(2))
    low, high = y + below, y + below + corridor
    top = high + above
    shapes: list[Shape] = []
    for side_low, side_high, line in ((y, low, low), (high, top, high)):
        edges = _edges(width, rooms, rng)
        for x0, x1 in pairwise(edges):
            shapes += _room(_Room(x0, side_low, x1, side_high, line), thickness, rng)
        shapes += [Wall((x, side_low), (x, side_high), thickness) for x in edges[1:-1]]
        if open_left:
            shapes.append(Wall((0.0, side_low), (0.0, side_high), thickness))
    return shapes, top - y


def _edges(width: float, rooms: int, rng: np.random.Generator) -> list[float]:
    """Where the walls between rooms stand: as many rooms, none narrower than two thirds of the mean."""
    shares = rng.uniform(0.67, 1.33, rooms)
    places = np.cumsum(shares / shares.sum()) * width
    return [0.0, *(round(float(place), 3) for place in places[:-1]), width]


def _room(room: _Room, thickness: float, rng: np.random.Generator) -> list[Shape]:
    """The wall with the door, and furniture against the other walls."""
    gap = float(rng.uniform(*_DOOR))
    low, high = room.x0 + 0.05, room.x1 - 0.05 - gap
    door = float(rng.uniform(low, high)) if high > low else room.x0 + 0.02
    y = room.door_y
    shapes: list[Shape] = [
        Wall((a, y), (b, y), thickness) for a, b in ((room.x0, door), (door + gap, room.x1)) if b - a > 0.01
    ]
    back = room.y0 if room.door_y == room.y1 else room.y1
    inward = 1.0 if back == room.y0 else -1.0
    if rng.random() < 0.7:
        shapes += _desk(room, back, inward, rng)
    if rng.random() < 0.4:
        shapes += _cupboard(room, back, inward, door, gap, rng)
    return shapes


def _desk(room: _Room, back: float, inward: float, rng: np.random.Generator) -> list[Shape]:
    """A block at the back wall, in a corner or not, that leaves room around it."""
    most = room.x1 - room.x0 - 2.0 * _FREE
    if most < 0.12:
        return []
    width, depth = float(rng.uniform(0.12, min(0.4, most))), float(rng.uniform(0.08, 0.18))
    corner = rng.random() < 0.4
    left = room.x0 if corner else float(rng.uniform(room.x0 + _FREE, room.x1 - _FREE - width))
    return [Box(left + width / 2, back + inward * depth / 2, width, depth)]


def _cupboard(
    room: _Room, back: float, inward: float, door: float, gap: float, rng: np.random.Generator
) -> list[Shape]:
    """A shallow block at a side wall, behind the door's half of the room."""
    depth = abs(room.y1 - room.y0)
    length, thick = float(rng.uniform(0.12, 0.25)), float(rng.uniform(0.05, 0.1))
    on_right = door + gap / 2 < (room.x0 + room.x1) / 2
    x = room.x1 - thick / 2 if on_right else room.x0 + thick / 2
    far = 0.2 + length / 2 + float(rng.uniform(0.0, max(0.0, depth - 0.2 - length - _FREE)))
    return [Box(x, back + inward * far, thick, length)] if depth > 0.2 + length + _FREE else []


def _moved(wall: Shape, dx: float) -> Shape:
    assert isinstance(wall, Box)
    return Box(wall.x + dx, wall.y, wall.width, wall.depth)


def _finished(shapes: list[Shape], description: str) -> WorldSpec:
    return with_starts(WorldSpec("office", tuple(shapes), description=description))
