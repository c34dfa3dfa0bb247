"""A world as plain data, independent of any file format and of any simulator.

Frame: x to the right, y up the page, lengths in m, angles in rad counter-clockwise; colors are RGB in [0, 1].
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field, replace
from typing import Any, TypeAlias

from .errors import WorldError
from .geometry import Point, Similarity, disk, rectangle, signed_area
from .robot import Pose

Color: TypeAlias = tuple[float, float, float]

WHITE: Color = (0.9, 0.9, 0.9)
WALL_HEIGHT = 0.10
"""Height (m) of shapes that do not say otherwise: above the camera, so that walls show against the sky."""


@dataclass(frozen=True, slots=True)
class Surface:
    """How a shape looks: a color, and a texture by name (see `textures`) laid over its sides.

    texture: name of a texture of the world, or None. tile: (width, height) m that one copy covers.
    """

    color: Color = WHITE
    texture: str | None = None
    tile: tuple[float, float] = (0.2, 0.1)


@dataclass(frozen=True, slots=True)
class Box:
    """A cuboid standing on the floor: center x, y (m), size along its own x and y (m), turned by `angle`."""

    x: float
    y: float
    width: float
    depth: float
    angle: float = 0.0
    height: float = WALL_HEIGHT
    surface: Surface = field(default_factory=Surface)

    def outline(self) -> tuple[Point, ...]:
        """Corners (m) on the floor, counter-clockwise."""
        return rectangle(self.x, self.y, self.width, self.depth, self.angle)

    def mapped(self, by: Similarity) -> Box:
        """The box where `by` puts it; its height stays, as that of all shapes."""
        x, y = by.point((self.x, self.y))
        width, depth = self.width * by.scale, self.depth * by.scale
        return replace(self, x=x, y=y, width=width, depth=depth, angle=by.angle(self.angle))


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder: center x, y (m) and radius (m)."""

    x: float
    y: float
    radius: float
    height: float = WALL_HEIGHT
    surface: Surface = field(default_factory=Surface)

    def outline(self) -> tuple[Point, ...]:
        """Corners (m) of the prism that stands for it in every sensor, counter-clockwise."""
        return disk(self.x, self.y, self.radius)

    def mapped(self, by: Similarity) -> Cylinder:
        """The cylinder where `by` puts it."""
        x, y = by.point((self.x, self.y))
        return replace(self, x=x, y=y, radius=self.radius * by.scale)


@dataclass(frozen=True, slots=True)
class Polygon:
    """An upright prism over a simple polygon: points (m) in order, either way round, not closed."""

    points: tuple[Point, ...]
    height: float = WALL_HEIGHT
    surface: Surface = field(default_factory=Surface)

    def outline(self) -> tuple[Point, ...]:
        """Corners (m) on the floor, counter-clockwise."""
        return self.points if signed_area(self.points) > 0 else self.points[::-1]

    def mapped(self, by: Similarity) -> Polygon:
        """The prism where `by` puts it, its points the same way round as before."""
        return replace(self, points=tuple(map(by.point, self.points[::-1] if by.mirrors else self.points)))


@dataclass(frozen=True, slots=True)
class Wall:
    """A straight wall: `thickness` (m) centered on the segment from `start` to `end` (m)."""

    start: Point
    end: Point
    thickness: float = 0.02
    height: float = WALL_HEIGHT
    surface: Surface = field(default_factory=Surface)

    def box(self) -> Box:
        """The box that it stands for."""
        (x0, y0), (x1, y1) = self.start, self.end
        length, angle = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
        return Box((x0 + x1) / 2, (y0 + y1) / 2, length, self.thickness, angle, self.height, self.surface)

    def outline(self) -> tuple[Point, ...]:
        """Corners (m) on the floor, counter-clockwise."""
        return self.box().outline()

    def mapped(self, by: Similarity) -> Wall:
        """The wall where `by` puts it."""
        start, end = by.point(self.start), by.point(self.end)
        return replace(self, start=start, end=end, thickness=self.thickness * by.scale)


Shape: TypeAlias = Box | Cylinder | Polygon | Wall


@dataclass(frozen=True, slots=True)
class MovableBox:
    """A box that robots can push: a shape, its mass (kg) and its friction coefficient."""

    box: Box
    mass: float = 0.05
    friction: float = 0.4


@dataclass(frozen=True, slots=True)
class Start:
    """A named place where a robot can begin."""

    name: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class Texture:
    """A pattern: `rows` of luminance in [0, 1], row 0 on top, multiplied with the surface's color."""

    name: str
    rows: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class Scenery:
    """Light, sky and floor.

    light: direction (x, y, z) towards the lamp. ambient: the share of light, 0..1, that comes from
    everywhere: at 1 all faces of one color look the same. floor_check: side (m) of the floor's squares.
    """

    light: tuple[float, float, float] = (0.62, 0.31, 0.72)
    ambient: float = 0.4
    sky: Color = (0.75, 0.85, 1.0)
    floor: Color = (0.55, 0.52, 0.48)
    floor_alternate: Color = (0.42, 0.40, 0.37)
    floor_check: float = 0.125


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """All that makes up a world. Immutable; readers and importers make it, simulators build from it.

    robots: start poses of robots beyond the first, which begins at one of `starts`.
    """

    name: str
    shapes: tuple[Shape, ...]
    starts: tuple[Start, ...] = ()
    movable: tuple[MovableBox, ...] = ()
    robots: tuple[Pose, ...] = ()
    scenery: Scenery = field(default_factory=Scenery)
    textures: tuple[Texture, ...] = ()
    description: str = ""

    def mapped(self, by: Similarity) -> WorldSpec:
        """The world with everything where `by` puts it."""

        def pose(of: Pose) -> Pose:
            return Pose(*by.point((of.x, of.y)), by.heading(of.heading))

        return replace(
            self,
            shapes=tuple(shape.mapped(by) for shape in self.shapes),
            starts=tuple(replace(start, pose=pose(start.pose)) for start in self.starts),
            robots=tuple(map(pose, self.robots)),
            movable=tuple(replace(movable, box=movable.box.mapped(by)) for movable in self.movable),
        )

    def with_starts(self, **poses: Pose) -> WorldSpec:
        """The world with starts of these names behind those it has."""
        return replace(self, starts=(*self.starts, *(Start(name, pose) for name, pose in poses.items())))

    def start(self, name: str) -> Pose:
        """The pose of the start called `name`.

        Raises: WorldError when there is none of this name; the message lists those there are.
        """
        for start in self.starts:
            if start.name == name:
                return start.pose
        known = ", ".join(start.name for start in self.starts) or "none"
        raise WorldError(f"world {self.name!r} has no start {name!r}; it has: {known}")

    @property
    def digest(self) -> str:
        """SHA-256 (hex) of everything but name and description: equal worlds have equal digests."""
        content: dict[str, Any] = {
            "shapes": [[type(shape).__name__, asdict(shape)] for shape in self.shapes],
            "starts": [asdict(start) for start in self.starts],
            "movable": [asdict(box) for box in self.movable],
            "robots": [asdict(pose) for pose in self.robots],
            "scenery": asdict(self.scenery),
            "textures": [asdict(texture) for texture in self.textures],
        }
        text = json.dumps(_canonical(content), sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()


def _canonical(value: Any) -> Any:
    """The same content with integers as floats, so that 1 and 1.0 give one digest."""
    if isinstance(value, dict):
        return {key: _canonical(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_canonical(item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return value


def room_walls(
    width: float,
    depth: float,
    thickness: float = 0.05,
    height: float = WALL_HEIGHT,
    surface: Surface | None = None,
) -> tuple[Shape, ...]:
    """Four walls around the inner rectangle (0, 0) to (width, depth), in m, outside of it.

    Raises: WorldError unless all sizes are positive.
    """
    if not all(math.isfinite(size) and size > 0 for size in (width, depth, thickness, height)):
        raise WorldError(
            f"a room's sizes must be positive: {width} x {depth} m, walls {thickness} x {height} m"
        )
    look = surface or Surface()
    long, half = width + 2 * thickness, thickness / 2
    return (
        Box(width / 2, -half, long, thickness, 0.0, height, look),
        Box(width + half, depth / 2, thickness, depth, 0.0, height, look),
        Box(width / 2, depth + half, long, thickness, 0.0, height, look),
        Box(-half, depth / 2, thickness, depth, 0.0, height, look),
    )
