"""Worlds made from worlds: mirrored, turned, scaled, and with other surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from .errors import WorldError
from .geometry import Plan, Point, Similarity
from .robot import wrap_angle

if TYPE_CHECKING:
    from .spec import Start, Surface, WorldSpec

_OTHER_SIDE = {"right": "left", "left": "right"}


def resurfaced(spec: WorldSpec, surfaces: Sequence[Surface]) -> WorldSpec:
    """The same world, the surfaces laid on its shapes in turn."""
    shapes = tuple(replace(shape, surface=surfaces[k % len(surfaces)]) for k, shape in enumerate(spec.shapes))
    return replace(spec, shapes=shapes if surfaces else spec.shapes)


def mirrored(spec: WorldSpec) -> WorldSpec:
    """The world seen in a mirror that stands along y; the starts `right` and `left` change places."""
    x0, _, x1, _ = Plan(spec.shapes).bounds
    mirror = Similarity(
        point=lambda point: (x0 + x1 - point[0], point[1]),
        heading=lambda heading: wrap_angle(math.pi - heading),
        angle=lambda angle: -angle if angle else 0.0,
        mirrors=True,
    )

    def renamed(start: Start) -> Start:
        return replace(start, name=_OTHER_SIDE.get(start.name, start.name))

    turned = spec.mapped(mirror)
    starts = sorted(map(renamed, turned.starts), key=lambda start: start.name, reverse=True)
    return replace(turned, starts=tuple(starts))


def rotated(spec: WorldSpec, angle: float) -> WorldSpec:
    """The world turned by `angle` (rad, counter-clockwise) around the middle of its bounds.

    The lamp and the floor's pattern stay where they are, as for a room built again under the same sky: what
    a camera sees changes, what touches and distances tell does not.
    """
    if angle == 0.0:
        return spec
    x0, y0, x1, y1 = Plan(spec.shapes).bounds
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    cosine, sine = math.cos(angle), math.sin(angle)

    def turned(point: Point) -> Point:
        dx, dy = point[0] - x, point[1] - y
        return x + cosine * dx - sine * dy, y + sine * dx + cosine * dy

    return spec.mapped(
        Similarity(turned, lambda heading: wrap_angle(heading + angle), lambda own: own + angle)
    )


def scaled(spec: WorldSpec, factor: float) -> WorldSpec:
    """The world `factor` times as wide and deep; heights stay, and so does what robots are.

    Raises: WorldError unless the factor is within 0.001..1000.
    """
    if not 1e-3 <= factor <= 1e3:
        raise WorldError(f"scale {factor:g} is outside 0.001 to 1000")
    if factor == 1.0:
        return spec
    return spec.mapped(Similarity(lambda point: (point[0] * factor, point[1] * factor), scale=factor))
