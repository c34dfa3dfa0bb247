"""Webots worlds: RectangleArena, boxes, cylinders, walls and e-pucks; a warning names what is skipped."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path

from ..errors import WorldFileError, WorldWarning
from ..geometry import Plan
from ..robot import EPUCK, Pose
from ..spec import Box, Cylinder, Shape, Start, WorldSpec
from ..starts import require_start, with_starts
from ..transforms import scaled
from .vrml import Node, parse_nodes
from .yamlnodes import read_text

SILENT = (
    *("WorldInfo", "Viewpoint", "Background", "TexturedBackground", "TexturedBackgroundLight"),
    *("DirectionalLight", "PointLight", "SpotLight", "Fog", "Floor"),
)
BOXES = {"WoodenBox": 0.6, "CardboardBox": 0.6, "SolidBox": 1.0, "PlasticCrate": 0.6, "MetalStorageBox": 0.6}
"""Box-like nodes and the side (m) each has when none is given."""
GROUPS = ("Solid", "Pose", "Transform", "Group")
SKIP_ABOVE = 0.05
"""Shapes that begin higher (m) than this do not touch an e-puck."""
MAX_BYTES = 5_000_000
MAX_SHAPES = 20_000
Place = tuple[float, float, float, float]
"""x, y, z (m) and heading (rad)."""


def load_webots(path: Path, scale: float = 1.0) -> WorldSpec:
    """The world in a .wbt file.

    Raises: WorldFileError naming file and line. Warns: WorldWarning for what it cannot take over.
    """
    return parse_webots(read_text(path, MAX_BYTES), str(path), path.stem, scale)


def parse_webots(text: str, source: str, name: str, scale: float = 1.0) -> WorldSpec:
    """A world from the text of a .wbt file; see `load_webots`."""
    collected = _Collector(source)
    try:
        for node in parse_nodes(text, source):
            collected.take(node, (0.0, 0.0, 0.0, 0.0), 0)
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

    def take(self, node: Node, at: Place, depth: int) -> None:
        if len(self.shapes) > MAX_SHAPES:
            raise WorldFileError(f"{self.source}: more than {MAX_SHAPES} shapes")
        if node.kind == "WorldInfo" and node.fields.get("coordinateSystem", ["ENU"]) != ["ENU"]:
            raise WorldFileError(f"{self.source}:{node.line}: only the coordinate system ENU is supported")
        if node.kind in SILENT:
            return
        place = _placed(node, at)
        if place is None:
            self._skip(f"{node.kind} (tilted)")
        elif node.kind == "RectangleArena":
            self._arena(node, place)
        elif node.kind in BOXES:
            side = BOXES[node.kind]
            self._box(place, node.numbers("size", (side, side, side)))
        elif node.kind == "Wall":
            width, depth_, height = node.numbers("size", (0.5, 5.0, 2.4))
            self._box((place[0], place[1], place[2] + height / 2, place[3]), (width, depth_, height))
        elif node.kind == "E-puck":
            self.robots.append(Pose(place[0], place[1], math.remainder(place[3], math.tau)))
        elif node.kind in GROUPS:
            self._group(node, place, depth)
        else:
            self._skip(node.kind)

    def _group(self, node: Node, place: Place, depth: int) -> None:
        bounds = node.nodes("boundingObject")
        shapes = bounds or [child for child in node.nodes("children") if child.kind == "Shape"]
        for shape in shapes:
            self._geometry(shape, place, depth)
        for child in node.nodes("children"):
            if child.kind != "Shape":
                self.take(child, place, depth + 1)

    def _geometry(self, node: Node, at: Place, depth: int) -> None:
        if node.kind == "Shape":
            for geometry in node.nodes("geometry"):
                self._geometry(geometry, at, depth + 1)
        elif node.kind in GROUPS:
            place = _placed(node, at)
            for child in node.nodes("children"):
                if place is not None:
                    self._geometry(child, place, depth + 1)
        elif node.kind == "Box":
            self._box(at, node.numbers("size", (2.0, 2.0, 2.0)))
        elif node.kind == "Cylinder":
            self._cylinder(at, node.numbers("radius", (1.0,))[0], node.numbers("height", (2.0,))[0])
        else:
            self._skip(node.kind)

    def _arena(self, node: Node, place: Place) -> None:
        width, depth = node.numbers("floorSize", (1.0, 1.0))
        thick, height = node.numbers("wallThickness", (0.01,))[0], node.numbers("wallHeight", (0.1,))[0]
        middle = place[2] + height / 2
        for x, y, size in (
            (0.0, -(depth + thick) / 2, (width + 2 * thick, thick, height)),
            (0.0, (depth + thick) / 2, (width + 2 * thick, thick, height)),
            (-(width + thick) / 2, 0.0, (thick, depth, height)),
            ((width + thick) / 2, 0.0, (thick, depth, height)),
        ):
            self._box(_moved(place, x, y, middle - place[2]), size)

    def _box(self, place: Place, size: tuple[float, ...]) -> None:
        width, depth, height = size
        if min(size) < 1e-4:
            raise WorldFileError(f"{self.source}: a box of {width:g} x {depth:g} x {height:g} m is no box")
        x, y, z, heading = place
        if self._touches_floor(z - height / 2, z + height / 2, "box"):
            self.shapes.append(Box(x, y, width, depth, heading, z + height / 2))

    def _cylinder(self, place: Place, radius: float, height: float) -> None:
        if min(radius, height) < 1e-4:
            raise WorldFileError(f"{self.source}: no cylinder has radius {radius:g} and height {height:g} m")
        x, y, z, _ = place
        if self._touches_floor(z - height / 2, z + height / 2, "cylinder"):
            self.shapes.append(Cylinder(x, y, radius, z + height / 2))

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


def _placed(node: Node, at: Place) -> Place | None:
    """Where a node stands, or None when it is turned about another axis than the vertical."""
    x, y, z = node.numbers("translation", (0.0, 0.0, 0.0))
    axis_x, axis_y, axis_z, angle = node.numbers("rotation", (0.0, 0.0, 1.0, 0.0))
    length = math.sqrt(axis_x**2 + axis_y**2 + axis_z**2)
    upright = length > 0 and math.hypot(axis_x, axis_y) / length < 1e-3
    if not upright and abs(math.remainder(angle, math.tau)) > 1e-3:
        return None
    moved = _moved(at, x, y, z)
    return (*moved[:3], moved[3] + math.copysign(angle, angle * axis_z if axis_z else angle))


def _moved(at: Place, x: float, y: float, z: float) -> Place:
    cosine, sine = math.cos(at[3]), math.sin(at[3])
    return at[0] + cosine * x - sine * y, at[1] + sine * x + cosine * y, at[2] + z, at[3]
