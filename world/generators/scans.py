"""Scanned floor plans: ROS maps as a laser makes them, at the scale of an e-puck.

Rooms are drawn on cells, furnished, turned by an angle, and then spoiled: edges get ragged, door posts stick
out, corners stay unknown, specks remain where somebody stood.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.uint8]

FREE, UNKNOWN, OCCUPIED = 254, 205, 0
"""Gray values as map savers write them."""
_CELL = 0.02
_MARGIN = 8


def scanned_plan(rng: np.random.Generator, image: str) -> tuple[str, bytes]:
    """The YAML and the PGM of a ROS map. image: the name of the image's file."""
    plan = _rooms(rng)
    _furnish(plan, rng)
    cells = _turned(plan, float(rng.uniform(-0.35, 0.35)) if rng.random() < 0.6 else 0.0)
    _spoil(cells, rng)
    header = f"P5\n{cells.shape[1]} {cells.shape[0]}\n255\n".encode("ascii")
    text = (
        f"image: {image}\nresolution: {_CELL}\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    return text, header + cells.tobytes()


def _rooms(rng: np.random.Generator) -> Cells:
    """One to five rooms: a rectangle split by walls of one to three cells, each with a door."""
    rows, columns = (int(size) for size in rng.integers(70, 125, 2))
    plan: Cells = np.full((rows, columns), FREE, dtype=np.uint8)
    thick = int(rng.integers(1, 4))
    plan[:thick], plan[-thick:], plan[:, :thick], plan[:, -thick:] = (OCCUPIED,) * 4
    rooms = [(thick, thick, rows - thick, columns - thick)]
    for _ in range(int(rng.integers(1, 5))):
        rooms.sort(key=lambda room: (room[2] - room[0]) * (room[3] - room[1]), reverse=True)
        if parts := _split(plan, rooms[0], int(rng.integers(1, 4)), rng):
            rooms[:1] = parts
    return plan


def _split(
    plan: Cells, room: tuple[int, int, int, int], thick: int, rng: np.random.Generator
) -> list[tuple[int, int, int, int]]:
    """Draws a wall across a room (rows and columns, from and to), with a door; nothing if it is too small."""
    r0, c0, r1, c1 = room
    across = r1 - r0 < c1 - c0
    low, high = (c0, c1) if across else (r0, r1)
    if high - low < 50:
        return []
    at = int(rng.integers(low + 22, high - 22))
    begin, end = (r0, r1) if across else (c0, c1)
    gap = int(rng.integers(8, 15))
    door = int(rng.integers(begin + 3, max(begin + 4, end - gap - 3)))
    post = int(rng.integers(0, 3))
    wall = plan[:, at : at + thick] if across else plan[at : at + thick].T
    wall[begin:end] = OCCUPIED
    wall[door : door + gap] = FREE
    wide = plan[:, at - post : at + thick + post] if across else plan[at - post : at + thick + post].T
    for place in (door - 2, door + gap):
        wide[max(begin, place) : min(end, place + 2)] = OCCUPIED
    if across:
        return [(r0, c0, r1, at), (r0, at + thick, r1, c1)]
    return [(r0, c0, at, c1), (at + thick, c0, r1, c1)]


def _furnish(plan: Cells, rng: np.random.Generator) -> None:
    """Blocks at walls, tables of four legs, pillars."""
    rows, columns = plan.shape
    for _ in range(int(rng.integers(2, 7))):
        height, width = (int(size) for size in rng.integers(4, 14, 2))
        r, c = int(rng.integers(2, rows - height - 2)), int(rng.integers(2, columns - width - 2))
        around = plan[max(0, r - 8) : r + height + 8, max(0, c - 8) : c + width + 8]
        kind = rng.random()
        if (
            kind < 0.45
            and (around != FREE).any()
            and (plan[r : r + height, c : c + width] == FREE).mean() > 0.9
        ):
            plan[r : r + height, c : c + width] = OCCUPIED
        elif (around == FREE).all():
            leg = int(rng.integers(1, 3))
            for dr in (0, height - leg) if kind < 0.85 else (height // 2,):
                for dc in (0, width - leg) if kind < 0.85 else (width // 2,):
                    plan[r + dr : r + dr + leg, c + dc : c + dc + leg] = OCCUPIED


def _turned(plan: Cells, angle: float) -> Cells:
    """The plan turned about its middle, what is outside unknown."""
    rows, columns = plan.shape
    cosine, sine = math.cos(angle), math.sin(angle)
    height = math.ceil(abs(rows * cosine) + abs(columns * sine)) + 2 * _MARGIN
    width = math.ceil(abs(rows * sine) + abs(columns * cosine)) + 2 * _MARGIN
    r, c = np.mgrid[0:height, 0:width]
    y, x = r - (height - 1) / 2, c - (width - 1) / 2
    source_r = np.rint(cosine * y - sine * x + (rows - 1) / 2).astype(int)
    source_c = np.rint(sine * y + cosine * x + (columns - 1) / 2).astype(int)
    inside = (source_r >= 0) & (source_r < rows) & (source_c >= 0) & (source_c < columns)
    cells: Cells = np.full((height, width), UNKNOWN, dtype=np.uint8)
    cells[inside] = plan[source_r[inside], source_c[inside]]
    return cells


def _spoil(cells: Cells, rng: np.random.Generator) -> None:
    """Ragged edges, specks, and corners that the laser never saw."""
    occupied = cells == OCCUPIED
    near = np.zeros_like(occupied)
    for axis in (0, 1):
        for step in (-1, 1):
            near |= np.roll(occupied, step, axis)
    noise = rng.random(cells.shape)
    cells[near & (cells == FREE) & (noise < 0.07)] = OCCUPIED
    free = np.argwhere(cells == FREE)
    for r, c in free[rng.integers(len(free), size=int(rng.integers(0, 4)))]:
        cells[r, c] = OCCUPIED
    for _ in range(int(rng.integers(0, 4))):
        edges = np.argwhere(near & (cells == FREE))
        r, c = edges[int(rng.integers(len(edges)))]
        height, width = (int(size) for size in rng.integers(3, 9, 2))
        pocket = cells[r : r + height, c : c + width]
        pocket[pocket == FREE] = UNKNOWN
