"""ROS map_server maps (YAML beside PGM or PNG): occupancy cells to straight walls.

Everything that is not the largest free area is solid: walls, cells never seen, and free specks that a robot
could not reach. https://wiki.ros.org/map_server gives the meaning of modes and thresholds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...files.yaml_nodes import Entry, parse_yaml
from ..errors import WorldFileError
from ..geometry import Point, signed_area
from ..robot import EPUCK
from ..spec import Box, Polygon, Shape, WorldSpec
from ..starts import require_start, with_starts
from ..transforms import scaled
from .bitmaps import Gray, read_bitmap
from .contours import outlines, straightened, walls_along

KEYS = ("image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
MODES = ("trinary", "scale", "raw")
NEGATE = {"0": False, "1": True, "false": False, "true": True, "no": False, "yes": True}
DENT = 5
"""Cells; narrower dents of a wall, and smaller bumps on it, are what a laser made of it."""
THICKNESS = 0.005
"""Meters that walls are thick at least, where a cell is less: no step of the physics gets through."""
MOST_CORNERS = 60
"""What stands free and has more corners is a ring of walls: a polygon's cover takes long to find."""
UNKNOWN = 205
"""Gray value (of 255) that map savers write for cells never seen."""
SPECK = 3
"""Patches of cells never seen that hold no square of this many cells are taken for free."""
MAX_STEPS = 500_000
MAX_SHAPES = 200_000
Mask = NDArray[np.bool_]


def parse_ros_map(text: str, source: str, folder: Path, name: str, scale: float = 1.0) -> WorldSpec:
    """As `ros_map`, from the text of the YAML."""
    return ros_map(parse_yaml(text, source, WorldFileError), source, folder, name, scale)


def ros_map(document: Entry, source: str, folder: Path, name: str, scale: float = 1.0) -> WorldSpec:
    """The world that a map_server YAML and its image describe, starts chosen beside a wall.

    folder: where the image is looked for. scale: what lengths are multiplied by, for a map that was made for
    a larger robot.

    Raises: WorldFileError naming `source`, line and key.
    """
    keys = document.mapping(KEYS, required=("image", "resolution", "origin"))
    resolution = keys["resolution"].number(1e-4, 100.0)
    x, y, yaw = keys["origin"].numbers(3)
    free = _free(keys, document, folder)
    area = largest_area(free)
    if not area.any():
        raise document.error("the map has no free cell")
    area = smoothed(area, resolution * scale)
    if not area.any():
        raise document.error("no free place is wide enough for a robot; is the scale right?")
    if (steps := _steps(area)) > MAX_STEPS:
        raise document.error(f"its walls have {steps} steps from cell to cell; the limit is {MAX_STEPS}")
    shapes = _shapes(area, resolution, (x, y, yaw), scale)
    spec = WorldSpec(name, shapes, description=f"imported from the ROS map {Path(source).name}")
    cosine, sine = math.cos(yaw), math.sin(yaw)

    def is_free(place: Point) -> bool:
        """Whether a place of the scaled world lies in the area."""
        east, north = place[0] / scale - x, place[1] / scale - y
        column = math.floor((cosine * east + sine * north) / resolution)
        row = len(area) - 1 - math.floor((cosine * north - sine * east) / resolution)
        return 0 <= row < area.shape[0] and 0 <= column < area.shape[1] and bool(area[row, column])

    return require_start(with_starts(scaled(spec, scale), is_free=is_free), source)


def _free(keys: dict[str, Entry], document: Entry, folder: Path) -> Mask:
    """The free cells of the image, as the YAML says to read it."""
    mode = _word(keys["mode"], MODES) if "mode" in keys else "trinary"
    negate = "negate" in keys and NEGATE[_word(keys["negate"], tuple(NEGATE))]
    occupied_above = keys["occupied_thresh"].number(0.0, 1.0) if "occupied_thresh" in keys else 0.65
    free_below = keys["free_thresh"].number(0.0, 1.0) if "free_thresh" in keys else 0.196
    if free_below > occupied_above:
        raise keys.get("free_thresh", document).error(f"{free_below:g} is above occupied_thresh")
    path = folder / keys["image"].text()
    try:
        image, opaque = read_bitmap(path)
    except WorldFileError as error:
        raise keys["image"].error(str(error)) from None
    return free_cells(image, mode, occupied_above, free_below, negate, opaque)


def _word(entry: Entry, known: tuple[str, ...]) -> str:
    """One of the known words, in whichever case it is written."""
    word = entry.text().lower()
    return word if word in known else entry.one_of(known)


def free_cells(
    image: Gray,
    mode: str,
    occupied_above: float,
    free_below: float,
    negate: bool,
    opaque: Mask | bool = True,
) -> Mask:
    """Which cells (rows, columns), row 0 on top, are free.

    trinary: those whose occupancy is below `free_below`, but not those of the gray that map savers write
    for unknown: it lies between the old default threshold (0.196) and the new one (0.25). scale: also those
    in between whose share of the way to `occupied_above` is under a half. raw: those whose value, in percent,
    is below `free_below`. Cells that are not `opaque` were never seen; such cells count as free where they
    are specks among free ones.
    """
    if mode == "raw":
        percent = np.round(image * 255.0)
        free, occupied = percent < free_below * 100.0, (percent > occupied_above * 100.0) & (percent <= 100.0)
        return _with_specks(free & opaque, occupied & opaque)
    occupancy = image if negate else 1.0 - image
    occupied = (occupancy > occupied_above) & opaque
    if mode == "scale" and occupied_above > free_below:
        free = (occupancy - free_below) / (occupied_above - free_below) < 0.5
        return _with_specks(free & opaque, occupied)
    free = (occupancy < free_below) & opaque
    known = free & (np.round(image * 255.0) != UNKNOWN)
    return _with_specks(known if known.any() else free, occupied)


def _with_specks(free: Mask, occupied: Mask) -> Mask:
    """The free cells and those never seen that lie in patches thinner than SPECK cells: shadows of rays."""
    return ~(occupied | opened(~free, SPECK, True))


def opened(mask: Mask, size: int, outside: bool) -> Mask:
    """The cells of a mask that lie in a disk of it, `size` cells across. outside: what is beyond its rim."""
    padded = np.pad(mask, size, constant_values=outside)
    height, width = padded.shape
    middle = (size - 1) / 2
    spots = [
        (row, column)
        for row in range(size)
        for column in range(size)
        if math.hypot(row - middle, column - middle) <= size / 2
    ]
    whole = np.ones((height - size + 1, width - size + 1), dtype=bool)
    for row, column in spots:
        whole &= padded[row : row + whole.shape[0], column : column + whole.shape[1]]
    covered = np.zeros(padded.shape, dtype=bool)
    for row, column in spots:
        covered[row : row + whole.shape[0], column : column + whole.shape[1]] |= whole
    return covered[size:-size, size:-size]


def eroded(mask: Mask, by: int) -> Mask:
    """The cells of a mask that are farther than `by` cells from all others."""
    padded = np.pad(mask, by, constant_values=True)
    left = np.ones_like(mask)
    for row in range(2 * by + 1):
        for column in range(2 * by + 1):
            left &= padded[row : row + mask.shape[0], column : column + mask.shape[1]]
    return left


def smoothed(area: Mask, cell: float) -> Mask:
    """The area without dents too narrow for a robot, and with the small bumps of its walls. cell: m.

    Thin walls stay: a bump is what stands out of something thicker by no more than DENT cells.
    """
    size = min(DENT, int(2.0 * EPUCK.body_radius / cell))
    if size < 2:
        return area
    thick = opened(~area, size, True)
    pieces = labeled(~area & ~thick)
    rows, columns = np.nonzero(pieces)
    piece = pieces[rows, columns]
    small = np.ones(int(pieces.max()) + 1, dtype=bool)
    for places in (rows, columns):
        low, high = np.full(len(small), np.iinfo(np.int64).max), np.zeros(len(small), dtype=np.int64)
        np.minimum.at(low, piece, places)
        np.maximum.at(high, piece, places)
        small &= high - low < size
    around = np.pad(thick, 1, constant_values=True)
    touched = around[:-2, 1:-1] | around[2:, 1:-1] | around[1:-1, :-2] | around[1:-1, 2:]
    attached = np.zeros(len(small), dtype=bool)
    attached[pieces[touched]] = True
    bumps = (pieces > 0) & (small & attached)[pieces]
    return largest_area(opened(area | bumps, size, False))


def largest_area(free: Mask) -> Mask:
    """The largest set of free cells that hang together by their sides."""
    labels = labeled(free)
    sizes = np.bincount(labels[free], minlength=1)
    area: Mask = free & (labels == int(sizes.argmax()))
    return area


def labeled(cells: Mask) -> NDArray[np.int64]:
    """A number for each set of cells that hang together by their sides, 0 for the others."""
    labels = np.zeros(cells.shape, dtype=np.int64)
    parents = [0]

    def root(label: int) -> int:
        while parents[label] != label:
            parents[label] = parents[parents[label]]
            label = parents[label]
        return label

    before: list[tuple[int, int, int]] = []
    for row in range(len(cells)):
        current = []
        for begin, end in _runs(cells[row]):
            above = {root(label) for low, high, label in before if low < end and begin < high}
            if above:
                label = min(above)
                for other in above:
                    parents[other] = label
            else:
                label = len(parents)
                parents.append(label)
            labels[row, begin:end] = label
            current.append((begin, end, label))
        before = current
    roots = np.array([root(label) for label in range(len(parents))])
    return np.asarray(roots[labels])


def _runs(row: Mask) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate(((False,), row, (False,))).astype(np.int8))).tolist()
    return list(zip(edges[0::2], edges[1::2], strict=True))


def merge_cells(solid: Mask) -> list[tuple[int, int, int, int]]:
    """Rectangles (row, column, rows, columns) that cover the solid cells once: equal runs joined."""
    done: list[tuple[int, int, int, int]] = []
    growing: dict[tuple[int, int], int] = {}
    for row in range(len(solid) + 1):
        runs = _runs(solid[row]) if row < len(solid) else []
        following = {run: growing.get(run, row) for run in runs}
        ended = [(run, top) for run, top in growing.items() if run not in following]
        done += [(top, begin, row - top, end - begin) for (begin, end), top in ended]
        growing = following
    return done


def _steps(area: Mask) -> int:
    """How many sides of cells the outlines of the area have."""
    padded = np.pad(area, 1)
    return int((padded[1:] != padded[:-1]).sum() + (padded[:, 1:] != padded[:, :-1]).sum())


def tolerance(cell: float) -> float:
    """Cells that a straight wall may be off the cells it was drawn with: 2, less where they are large (m)."""
    return max(1.0, min(2.0, 0.02 / cell))


def _shapes(
    area: Mask, resolution: float, origin: tuple[float, float, float], scale: float
) -> tuple[Shape, ...]:
    """Walls around the area and what stands free in it, as straight as its cells allow.

    Boxes fill what is behind them.
    """
    x, y, yaw = origin
    cosine, sine = math.cos(yaw), math.sin(yaw)

    def placed(points: Sequence[Point]) -> tuple[Point, ...]:
        """Corners of cells, rows counted upward, in the world's frame."""
        return tuple(
            (
                x + resolution * (cosine * along - sine * up),
                y + resolution * (sine * along + cosine * up),
            )
            for along, up in points
        )

    shapes: list[Shape] = []
    off, thickness = tolerance(resolution * scale), max(1.0, THICKNESS / (resolution * scale))
    core = int(off) + 2
    rows, columns = np.flatnonzero(area.any(axis=1)), np.flatnonzero(area.any(axis=0))
    around = np.zeros_like(area)
    around[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = True
    for row, column, deep, wide in merge_cells(eroded(~area, core) & around):
        (middle,) = placed([(column + wide / 2, len(area) - row - deep / 2)])
        shapes.append(Box(*middle, wide * resolution, deep * resolution, yaw))
    for loop in outlines(area[::-1]):
        points = straightened(loop, off)
        stands_free = signed_area(points) < 0.0
        if stands_free and len(points) <= MOST_CORNERS:
            shapes.append(Polygon(placed(points)))
        else:
            shapes += [Polygon(placed(quad)) for quad in walls_along(points, thickness)]
    if len(shapes) > MAX_SHAPES:
        raise WorldFileError(f"the map needs {len(shapes)} walls, more than the limit of {MAX_SHAPES}")
    return tuple(shapes)
