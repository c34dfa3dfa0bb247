"""Writes a world as a world file, version 1: what `worldfile` reads."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable

from ..errors import WorldError
from ..geometry import Point
from ..spec import WALL_HEIGHT, Box, Cylinder, Polygon, Shape, Surface, Wall, WorldSpec

_DIGITS = 6


def world_text(spec: WorldSpec) -> str:
    """The text of a world file that reads as `spec`, lengths to the micrometer, angles to 1e-6 degrees.

    Raises: WorldError for what such a file cannot say: textures, movable boxes, a scenery of its own.
    """
    if spec.textures or spec.movable or spec.scenery != WorldSpec("", ()).scenery:
        raise WorldError(
            f"world {spec.name!r} has textures, movable boxes or scenery; these cannot be written"
        )
    lines = ["tolman-world: 1", *([f"description: {_text(spec.description)}"] if spec.description else [])]
    for key, kind in (("boxes", Box), ("walls", Wall), ("cylinders", Cylinder), ("polygons", Polygon)):
        shapes = [shape for shape in spec.shapes if isinstance(shape, kind)]
        lines += [f"{key}:", *(f"  - {{{_shape(shape)}}}" for shape in shapes)] if shapes else []
    for key, poses in (("starts", spec.starts),):
        lines += [f"{key}:"] if poses else []
        for start in poses:
            pose = start.pose
            lines.append(f"  {_text(start.name)}: {_list((pose.x, pose.y, math.degrees(pose.heading)))}")
    if spec.robots:
        lines.append("robots:")
        lines += [f"  - {_list((pose.x, pose.y, math.degrees(pose.heading)))}" for pose in spec.robots]
    return "\n".join(lines) + "\n"


def _text(text: str) -> str:
    """The text as it stands, or in quotes where YAML would read something else."""
    return text if re.fullmatch(r"[A-Za-z][\w ,.()/-]*", text) else json.dumps(text, ensure_ascii=False)


def _shape(shape: Shape) -> str:
    if isinstance(shape, Box):
        parts = [f"at: {_list((shape.x, shape.y))}", f"size: {_list((shape.width, shape.depth))}"]
        parts += [f"angle: {_number(math.degrees(shape.angle))}"] if shape.angle else []
    elif isinstance(shape, Wall):
        parts = [
            f"from: {_list(shape.start)}",
            f"to: {_list(shape.end)}",
            f"thickness: {_number(shape.thickness)}",
        ]
    elif isinstance(shape, Cylinder):
        parts = [f"at: {_list((shape.x, shape.y))}", f"radius: {_number(shape.radius)}"]
    else:
        parts = [f"points: [{', '.join(_list(point) for point in shape.points)}]"]
    parts += [f"height: {_number(shape.height)}"] if shape.height != WALL_HEIGHT else []
    parts += [f"color: {_list(shape.surface.color)}"] if shape.surface.color != Surface().color else []
    return ", ".join(parts)


def _list(values: Iterable[float] | Point) -> str:
    return f"[{', '.join(_number(value) for value in values)}]"


def _number(value: float) -> str:
    text = f"{value:.{_DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
