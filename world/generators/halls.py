"""Halls without straight walls: curves, alcoves, round pillars."""

from __future__ import annotations

import math

import numpy as np

from ..geometry import Point
from ..spec import Cylinder, Shape, Wall, WorldSpec
from ..starts import with_starts

_FREE = 0.2
"""Meters between a pillar and all else, at least."""
_THICK = 0.02


def hall(rng: np.random.Generator) -> WorldSpec:
    """A closed curve with one straight side, alcoves in the rest, and pillars inside."""
    while True:
        curve = _curve(rng)
        spec = with_starts(
            WorldSpec("hall", tuple(_walls(curve, rng)), description="a hall with curved walls")
        )
        if spec.starts:
            return spec


def _curve(rng: np.random.Generator) -> list[Point]:
    """Points (m) of a curve around the origin, its lower part cut off straight."""
    radius = float(rng.uniform(0.6, 1.0))
    waves = [(k, float(rng.uniform(0.0, 0.22 / k)), float(rng.uniform(0.0, math.tau))) for k in (2, 3, 4)]
    steps = int(rng.integers(40, 80))
    alcove = float(rng.uniform(0.1, math.pi - 0.1)) if rng.random() < 0.6 else None
    points = []
    for step in range(steps):
        angle = math.tau * step / steps
        reach = radius * (1.0 + sum(size * math.cos(k * angle + phase) for k, size, phase in waves))
        if alcove is not None and abs(angle - alcove) < 0.22:
            reach += 0.18
        points.append((reach * math.cos(angle), max(-0.55 * radius, reach * math.sin(angle))))
    return points


def _walls(curve: list[Point], rng: np.random.Generator) -> list[Shape]:
    shapes: list[Shape] = [
        Wall(a, b, _THICK)
        for a, b in zip(curve, [*curve[1:], curve[0]], strict=True)
        if math.dist(a, b) > 1e-3
    ]
    pillars: list[Cylinder] = []
    for _ in range(int(rng.integers(0, 4))):
        radius = float(rng.uniform(0.03, 0.09))
        x, y = (float(value) for value in rng.uniform(-0.4, 0.4, 2))
        clear = min(math.dist((x, y), point) for point in curve) - radius
        apart = all(math.dist((x, y), (p.x, p.y)) > radius + p.radius + _FREE for p in pillars)
        if clear > _FREE and apart:
            pillars.append(Cylinder(x, y, radius))
    return [*shapes, *pillars]
