"""Arrangements of shapes that several tests of sensors are done in."""

from __future__ import annotations

import numpy as np
from tolman.world import WorldSpec
from tolman.world.spec import Box, Cylinder, Polygon, Shape, room_walls

SQUARE = WorldSpec("square", room_walls(2.0, 2.0))
MIXED = (
    *room_walls(2.0, 2.0),
    Box(0.5, 0.5, 0.3, 0.1, 0.4, 0.02),
    Cylinder(1.4, 0.6, 0.12, 0.06),
    Polygon(((0.3, 1.2), (0.8, 1.2), (0.8, 1.7), (0.55, 1.35), (0.3, 1.7)), 0.025),
)


def random_shapes(random: np.random.Generator) -> tuple[Shape, ...]:
    """A room of 2 x 2 m with boxes, cylinders and polygons anywhere, some of them overlapping."""
    places = random.uniform(0.3, 1.7, (9, 2)).tolist()
    boxes = [
        Box(
            x,
            y,
            random.uniform(0.05, 0.4),
            random.uniform(0.05, 0.4),
            random.uniform(-3, 3),
            random.uniform(0.01, 0.1),
        )
        for x, y in places[:4]
    ]
    cylinders = [Cylinder(x, y, random.uniform(0.02, 0.2), random.uniform(0.01, 0.1)) for x, y in places[4:7]]
    polygons = [
        Polygon(tuple((x + size * u, y + size * v) for u, v in ((0, 0), (1, 0.2), (0.8, 1), (0.4, 0.3))))
        for (x, y), size in zip(places[7:], random.uniform(0.1, 0.4, 2).tolist(), strict=True)
    ]
    return (*room_walls(2.0, 2.0), *boxes, *cylinders, *polygons)
