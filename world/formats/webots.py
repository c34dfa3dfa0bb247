"""Webots worlds: RectangleArena, boxes, cylinders, walls and e-pucks; a warning names what is skipped."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import WorldFileError, WorldWarning
from ..geometry import Plan
from ..robot import EPUCK, Pose
from ..spec import Box, Cylinder, Shape, Start, WorldSpec
from ..starts import require_start, with_starts
from ..transforms import scaled
from .vrml import Node, parse_nodes, version_of

SILENT = (
    *("WorldInfo", "Viewpoint", "Background", "TexturedBackground", "TexturedBackgroundLight"),
    *("DirectionalLight", "PointLight", "SpotLight", "Fog", "Floor"),
)
BOXES = {"WoodenBox": 0.6, "CardboardBox": 0.6, "SolidBox": 1.0, "PlasticCrate": 0.6, "MetalStorageBox": 0.6}
"""Box-like nodes and the side (m) each has when none is given."""
GROUPS = ("Solid", "Pose", "Transform", "Group")
SKIP_ABOVE = 0.05
"""Shapes that begin higher (m) than this do not touch an e-puck."""
MAX_SHAPES = 20_000
MAX_NODES = 100_000
"""Nodes that are looked at; with USE a short file can stand for endlessly many."""
ENU_SINCE = (2022, "a")
"""Since this version of Webots z is up in new worlds, and in all its objects."""
CONVERT = "save it with z up (coordinateSystem ENU) by a newer Webots"


@dataclass(frozen=True, slots=True)
class Place:
    """Where a node's own coordinates are in the world. x, y, z: m. heading: rad.

    scale: what lengths along the node's own axes are multiplied by, before it is turned and moved.
    """

    x: float
    y: float
    z: float
    heading: float
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def point(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """The node's point (x, y, z) in the world."""
        x, y = x * self.scale[0], y * self.scale[1]
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        return self.x + cosine * x - sine * y, self.y + sine * x + cosine * y, self.z + z * self.scale[2]

    def moved(self, x: float, y: float, z: float = 0.0) -> Place:
        """The same at another point of the node's own."""
        x, y, z = self.point(x, y, z)
        return replace(self, x=x, y=y, z=z)


ORIGIN = Place(0.0, 0.0, 0.0, 0.0)


def parse_webots(text: str, source: str, name: str, scale: float = 1.0) -> WorldSpec:
    """A world from the text of a .wbt file.

    Raises: WorldFileError naming `source` and line. Warns: WorldWarning for what it cannot take over.
    """
    collected = _Collector(source)
    try:
        if version_of(text, source) < ENU_SINCE:
            raise WorldFileError(f"{source}:1: a y-up world, of before Webots R2022a; {CONVERT}")
        for node in parse_nodes(text, source):
            collected.take(node, ORIGIN)
    except ValueError as error:
        raise error if isinstance(error, WorldFileError) else WorldFileError(f"{source}: {error}") from None
    except RecursionError:
        raise WorldFileError(f"{source}: nested too deeply") from None
    collected.warn()
    if not collected.shapes:
        raise WorldFileError(f"{source}: no arena, box, cylinder or wall in this world")
    about = f"imported from the Webots world {Path(source).name}"
    spec = WorldSpec(name, tuple(collected.shapes), description=about)
    spec = scaled(spec, scale)
    poses = [replace(pose, x=pose.x * scale, y=pose.y * scale) for pose in collected.robots]
    fitting = _fitting(spec, poses)
    starts = (Start("robot", fitting[0]),) if fitting else ()
    return require_start(with_starts(replace(spec, starts=starts, robots=tuple(fitting[1:]))), source)


def _fitting(spec: WorldSpec, poses: list[Pose]) -> list[Pose]:
    plan = Plan(spec.shapes)
    return [pose for pose in poses if plan.clearance(pose.x, pose.y) > EPUCK.body_radius]


class _Collector:
    def __init__(self, source: str) -> None:
        self.source = source
        self.shapes: list[Shape] = []
        self.robots: list[Pose] = []
        self.skipped: dict[str, int] = {}
        self._seen = 0

    def take(self, node: Node, at: Place) -> None:
        self._count()
        if node.kind == "WorldInfo" and node.fields.get("coordinateSystem", ["ENU"]) != ["ENU"]:
            raise WorldFileError(f"{self.source}:{node.line}: a world whose z is not up; {CONVERT}")
        if node.kind in SILENT:
            return
        place = self._placed(node, at)
        if place is None:
            return
        if node.kind == "RectangleArena":
            self._arena(node, place)
        elif node.kind in BOXES:
            side = BOXES[node.kind]
            self._box(place, node.numbers("size", (side, side, side)))
        elif node.kind == "Wall":
            width, depth, height = node.numbers("size", (0.5, 5.0, 2.4))
            self._box(place.moved(0.0, 0.0, height / 2), (width, depth, height))
        elif node.kind == "E-puck":
            self.robots.append(Pose(place.x, place.y, math.remainder(place.heading, math.tau)))
        elif node.kind in GROUPS:
            self._group(node, place)
        else:
            self._skip(node.kind)

    def _count(self) -> None:
        self._seen += 1
        if self._seen > MAX_NODES or len(self.shapes) > MAX_SHAPES:
            raise WorldFileError(f"{self.source}: more than {MAX_SHAPES} shapes or {MAX_NODES} nodes")

    def _placed(self, node: Node, at: Place) -> Place | None:
        """Where a node stands; None, and noted, where it is tilted or sheared."""
        x, y, z = node.numbers("translation", (0.0, 0.0, 0.0))
        axis_x, axis_y, axis_z, angle = node.numbers("rotation", (0.0, 0.0, 1.0, 0.0))
        length = math.sqrt(axis_x**2 + axis_y**2 + axis_z**2)
        turns = abs(math.remainder(angle, math.tau)) > 1e-3
        if turns and not (length > 0 and math.hypot(axis_x, axis_y) / length < 1e-3):
            self._skip(f"{node.kind} (tilted)")
            return None
        angle = math.copysign(angle, angle * axis_z if axis_z else angle)
        along, aside, up = at.scale
        if turns and abs(along - aside) > 1e-6 * along:
            if abs(math.remainder(angle, math.pi / 2)) > 1e-3:
                self._skip(f"{node.kind} (sheared by the scale of what it is in)")
                return None
            if abs(math.remainder(angle, math.pi)) > 1e-3:
                along, aside = aside, along
        own = [abs(factor) for factor in node.numbers("scale", (1.0, 1.0, 1.0))]
        if min(own) < 1e-6:
            raise WorldFileError(f"{self.source}:{node.line}: {node.kind} is scaled to nothing")
        scale = (along * own[0], aside * own[1], up * own[2])
        return replace(at.moved(x, y, z), heading=at.heading + angle, scale=scale)

    def _group(self, node: Node, place: Place) -> None:
        bounds = node.nodes("boundingObject")
        shapes = bounds or [child for child in node.nodes("children") if child.kind == "Shape"]
        for shape in shapes:
            self._geometry(shape, place)
        for child in node.nodes("children"):
            if child.kind != "Shape":
                self.take(child, place)

    def _geometry(self, node: Node, at: Place) -> None:
        self._count()
        if node.kind == "Shape":
            for geometry in node.nodes("geometry"):
                self._geometry(geometry, at)
        elif node.kind in GROUPS:
            place = self._placed(node, at)
            for child in node.nodes("children"):
                if place is not None:
                    self._geometry(child, place)
        elif node.kind == "Box":
            self._box(at, node.numbers("size", (2.0, 2.0, 2.0)))
        elif node.kind == "Cylinder":
            self._cylinder(at, node.numbers("radius", (1.0,))[0], node.numbers("height", (2.0,))[0])
        else:
            self._skip(node.kind)

    def _arena(self, node: Node, place: Place) -> None:
        width, depth = node.numbers("floorSize", (1.0, 1.0))
        thick, height = node.numbers("wallThickness", (0.01,))[0], node.numbers("wallHeight", (0.1,))[0]
        for x, y, size in (
            (0.0, -(depth + thick) / 2, (width + 2 * thick, thick, height)),
            (0.0, (depth + thick) / 2, (width + 2 * thick, thick, height)),
            (-(width + thick) / 2, 0.0, (thick, depth, height)),
            ((width + thick) / 2, 0.0, (thick, depth, height)),
        ):
            self._box(place.moved(x, y, height / 2), size)

    def _box(self, place: Place, size: tuple[float, ...]) -> None:
        width, depth, height = (side * factor for side, factor in zip(size, place.scale, strict=True))
        if min(width, depth, height) < 1e-4:
            raise WorldFileError(f"{self.source}: a box of {width:g} x {depth:g} x {height:g} m is no box")
        if self._touches_floor(place.z - height / 2, place.z + height / 2, "box"):
            self.shapes.append(Box(place.x, place.y, width, depth, place.heading, place.z + height / 2))

    def _cylinder(self, place: Place, radius: float, height: float) -> None:
        along, aside, up = place.scale
        radius, height = radius * along, height * up
        if abs(along - aside) > 1e-6 * along:
            self._skip("Cylinder (scaled to an ellipse)")
            return
        if min(radius, height) < 1e-4:
            raise WorldFileError(f"{self.source}: no cylinder has radius {radius:g} and height {height:g} m")
        if self._touches_floor(place.z - height / 2, place.z + height / 2, "cylinder"):
            self.shapes.append(Cylinder(place.x, place.y, radius, place.z + height / 2))

    def _touches_floor(self, bottom: float, top: float, what: str) -> bool:
        if bottom < SKIP_ABOVE and top > 1e-3:
            return True
        self._skip(f"{what} (off the floor)")
        return False

    def _skip(self, kind: str) -> None:
        self.skipped[kind] = self.skipped.get(kind, 0) + 1

    def warn(self) -> None:
        if self.skipped:
            what = ", ".join(f"{count} {kind}" for kind, count in sorted(self.skipped.items()))
            warnings.warn(f"{self.source}: skipped: {what}", WorldWarning, stacklevel=4)
