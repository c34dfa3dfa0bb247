"""The YAML world format, version 1 (docs/worlds.md): text to `WorldSpec`, with errors that say where."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ...files.yaml_nodes import Entry, parse_yaml
from ..errors import WorldError, WorldFileError
from ..geometry import Point, signed_area
from ..robot import Pose, wrap_angle
from ..spec import (
    WALL_HEIGHT,
    Box,
    Color,
    Cylinder,
    MovableBox,
    Polygon,
    Scenery,
    Shape,
    Start,
    Surface,
    Texture,
    Wall,
    WorldSpec,
    room_walls,
)
from ..starts import require_start, with_starts
from ..transforms import mirrored, resurfaced, scaled
from .textures import read_textures

VERSION = 1
SIZE = (1e-3, 1e3)
"""Smallest and largest length (m) of anything in a world file."""
LOOK_KEYS = ("height", "color", "texture", "tile")
SHAPE_KEYS = ("room", "boxes", "walls", "cylinders", "polygons")
TOP_KEYS = (
    *("tolman-world", "name", "description", "based-on", "mirror"),
    *SHAPE_KEYS,
    *("surfaces", "starts", "robots", "movable", "scenery", "textures"),
)
COLORS: dict[str, Color] = {
    "white": (0.9, 0.9, 0.9),
    "black": (0.05, 0.05, 0.05),
    "gray": (0.5, 0.5, 0.5),
    "red": (0.85, 0.15, 0.1),
    "green": (0.1, 0.65, 0.2),
    "blue": (0.15, 0.25, 0.85),
    "yellow": (0.95, 0.85, 0.15),
    "orange": (0.95, 0.5, 0.1),
    "purple": (0.55, 0.2, 0.7),
}
Lookup = Callable[[str], WorldSpec]


def complete_world(document: Entry, path: Path, lookup: Lookup | None, scale: float = 1.0) -> WorldSpec:
    """The world that a file describes; its name defaults to the file's, and starts are chosen if it has none.

    lookup: finds the world that a `based-on` key names. scale: what lengths are multiplied by.

    Raises: WorldFileError naming file, line and key.
    """
    spec = scaled(_world(document, path.stem, lookup, path.parent), scale)
    return spec if spec.starts else require_start(with_starts(spec), str(path))


def parse_world(
    text: str, source: str, name: str, lookup: Lookup | None = None, folder: Path | None = None
) -> WorldSpec:
    """A world from the text of a file. folder: where bitmaps that it names are looked for.

    Raises: WorldFileError naming `source`, line and key.
    """
    return _world(parse_yaml(text, source, WorldFileError), name, lookup, folder)


def _world(document: Entry, name: str, lookup: Lookup | None, folder: Path | None) -> WorldSpec:
    top = document.mapping(TOP_KEYS, required=("tolman-world",))
    top["tolman-world"].integer(VERSION, VERSION)
    base = _base(top, lookup, name)
    shapes = (*base.shapes, *_shapes(top))
    if not shapes:
        raise document.error(f"a world needs at least one of {', '.join(SHAPE_KEYS)}")
    spec = replace(
        base,
        name=top["name"].text() if "name" in top else name,
        description=top["description"].text() if "description" in top else base.description,
        shapes=shapes,
        starts=_starts(top["starts"]) if "starts" in top else base.starts,
        robots=tuple(top["robots"].each(_pose)) if "robots" in top else base.robots,
        movable=(*base.movable, *(top["movable"].each(_movable) if "movable" in top else ())),
        scenery=_scenery(top["scenery"], base.scenery) if "scenery" in top else base.scenery,
        textures=(*base.textures, *_textures(top, folder)),
    )
    if "surfaces" in top:
        spec = resurfaced(spec, top["surfaces"].each(_look))
    _check_textures(spec, document)
    return mirrored(spec) if "mirror" in top and top["mirror"].flag() else spec


def _base(top: dict[str, Entry], lookup: Lookup | None, name: str) -> WorldSpec:
    if "based-on" not in top:
        return WorldSpec(name, ())
    if lookup is None:
        raise top["based-on"].error("only files among the built-in worlds can be based on another")
    try:
        return lookup(top["based-on"].text())
    except WorldFileError:
        raise
    except WorldError as error:
        raise top["based-on"].error(str(error)) from None


def _shapes(top: dict[str, Entry]) -> list[Shape]:
    shapes: list[Shape] = []
    if "room" in top:
        room = top["room"].mapping(("size", "thickness", *LOOK_KEYS), required=("size",))
        thickness = room["thickness"].number(*SIZE) if "thickness" in room else 0.05
        width, depth = room["size"].numbers(2, *SIZE)
        shapes += room_walls(width, depth, thickness, _height(room), _surface(room))
    readers: tuple[tuple[str, Callable[[Entry], Shape]], ...] = (
        ("boxes", _box),
        ("walls", _wall),
        ("cylinders", _cylinder),
        ("polygons", _polygon),
    )
    for key, read in readers:
        shapes += top[key].each(read) if key in top else ()
    return shapes


def _box(entry: Entry) -> Box:
    keys = entry.mapping(("corners", "at", "size", "angle", *LOOK_KEYS))
    if ("corners" in keys) == ("at" in keys):
        raise entry.error("a box has either 'corners: [[x0, y0], [x1, y1]]' or 'at: [x, y]' with 'size'")
    if "at" in keys:
        x, y = _point(keys["at"])
        if "size" not in keys:
            raise entry.error("the key 'size' is missing")
        width, depth = keys["size"].numbers(2, *SIZE)
        angle = math.radians(keys["angle"].number()) if "angle" in keys else 0.0
        return Box(x, y, width, depth, angle, _height(keys), _surface(keys))
    for key in ("size", "angle"):
        if key in keys:
            raise keys[key].error("goes with 'at', not with 'corners'")
    (x0, y0), (x1, y1) = (_point(corner) for corner in keys["corners"].items(2))
    if min(abs(x1 - x0), abs(y1 - y0)) < SIZE[0]:
        raise keys["corners"].error(f"the box would be thinner than {SIZE[0]:g} m")
    return Box((x0 + x1) / 2, (y0 + y1) / 2, abs(x1 - x0), abs(y1 - y0), 0.0, _height(keys), _surface(keys))


def _wall(entry: Entry) -> Wall:
    keys = entry.mapping(("from", "to", "thickness", *LOOK_KEYS), required=("from", "to"))
    start, end = _point(keys["from"]), _point(keys["to"])
    if math.dist(start, end) < SIZE[0]:
        raise entry.error(f"the wall would be shorter than {SIZE[0]:g} m")
    thickness = keys["thickness"].number(*SIZE) if "thickness" in keys else 0.02
    return Wall(start, end, thickness, _height(keys), _surface(keys))


def _cylinder(entry: Entry) -> Cylinder:
    keys = entry.mapping(("at", "radius", *LOOK_KEYS), required=("at", "radius"))
    x, y = _point(keys["at"])
    return Cylinder(x, y, keys["radius"].number(*SIZE), _height(keys), _surface(keys))


def _polygon(entry: Entry) -> Polygon:
    keys = entry.mapping(("points", *LOOK_KEYS), required=("points",))
    points = tuple(keys["points"].each(_point))
    if len(points) < 3 or abs(signed_area(points)) < SIZE[0] ** 2:
        raise keys["points"].error("a polygon needs at least 3 points around an area")
    return Polygon(points, _height(keys), _surface(keys))


def _movable(entry: Entry) -> MovableBox:
    keys = entry.mapping(("at", "size", "angle", "mass", "friction", *LOOK_KEYS), required=("at", "size"))
    x, y = _point(keys["at"])
    width, depth = keys["size"].numbers(2, *SIZE)
    angle = math.radians(keys["angle"].number()) if "angle" in keys else 0.0
    mass = keys["mass"].number(1e-3, 100.0) if "mass" in keys else 0.05
    friction = keys["friction"].number(0.0, 2.0) if "friction" in keys else 0.4
    return MovableBox(Box(x, y, width, depth, angle, _height(keys), _surface(keys)), mass, friction)


def _point(entry: Entry) -> Point:
    x, y = entry.numbers(2)
    return x, y


def _pose(entry: Entry) -> Pose:
    x, y, degrees = entry.numbers(3)
    return Pose(x, y, wrap_angle(math.radians(degrees)))


def _starts(entry: Entry) -> tuple[Start, ...]:
    return tuple(Start(name, _pose(value)) for name, value in entry.mapping().items())


def _height(keys: dict[str, Entry]) -> float:
    return keys["height"].number(*SIZE) if "height" in keys else WALL_HEIGHT


def _look(entry: Entry) -> Surface:
    return _surface(entry.mapping(("color", "texture", "tile")))


def _surface(keys: dict[str, Entry]) -> Surface:
    default = Surface()
    tile = keys["tile"].numbers(2, *SIZE) if "tile" in keys else default.tile
    return Surface(
        _color(keys["color"]) if "color" in keys else default.color,
        keys["texture"].text() if "texture" in keys else None,
        (tile[0], tile[1]),
    )


def _color(entry: Entry) -> Color:
    if not entry.is_list:
        return COLORS[entry.one_of(COLORS)]
    red, green, blue = entry.numbers(3, 0.0, 1.0)
    return red, green, blue


def _scenery(entry: Entry, base: Scenery) -> Scenery:
    keys = entry.mapping(("light", "ambient", "sky", "floor", "floor-alternate", "floor-check"))
    light = keys["light"].numbers(3) if "light" in keys else base.light
    if not any(light):
        raise keys["light"].error("a direction cannot be all zero")
    return Scenery(
        (light[0], light[1], light[2]),
        keys["ambient"].number(0.0, 1.0) if "ambient" in keys else base.ambient,
        _color(keys["sky"]) if "sky" in keys else base.sky,
        _color(keys["floor"]) if "floor" in keys else base.floor,
        _color(keys["floor-alternate"]) if "floor-alternate" in keys else base.floor_alternate,
        keys["floor-check"].number(*SIZE) if "floor-check" in keys else base.floor_check,
    )


def _textures(top: dict[str, Entry], folder: Path | None) -> tuple[Texture, ...]:
    return read_textures(top["textures"], folder) if "textures" in top else ()


def _check_textures(spec: WorldSpec, document: Entry) -> None:
    known = [texture.name for texture in spec.textures]
    boxes = [movable.box for movable in spec.movable]
    for shape in (*spec.shapes, *boxes):
        name = shape.surface.texture
        if name is not None and name not in known:
            raise document.error(f"no texture is called {name!r}; known: {', '.join(known) or 'none'}")
