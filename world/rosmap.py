"""ROS map_server maps (YAML beside PGM or PNG): occupancy cells to few boxes.

Everything that is not the largest free area is solid: walls, cells never seen, and free specks that a robot
could not reach. https://wiki.ros.org/map_server gives the meaning of modes and thresholds.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .base import WorldFileError
from .bitmaps import Gray, read_bitmap
from .spec import Box, Shape, WorldSpec
from .starts import require_start, with_starts
from .transforms import scaled
from .yamlnodes import Entry, read_text, read_yaml

KEYS = ("image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
MODES = ("trinary", "scale", "raw")
RIM = 2
"""Cells around the free area that are kept solid."""
UNKNOWN = 205
"""Gray value (of 255) that map savers write for cells never seen."""
SPECK = 3
"""Patches of cells never seen that hold no square of this many cells are taken for free."""
MAX_BOXES = 200_000
Mask = NDArray[np.bool_]


def load_ros_map(path: Path, scale: float = 1.0) -> WorldSpec:
    """The world that a map_server YAML and its image describe, starts chosen beside a wall.

    scale: what lengths are multiplied by, for a map that was made for a larger robot.

    Raises: WorldFileError naming file, line and key.
    """
    return parse_ros_map(read_text(path), str(path), path.parent, path.stem, scale)


def parse_ros_map(text: str, source: str, folder: Path, name: str, scale: float = 1.0) -> WorldSpec:
    """A world from the text of a map_server YAML; `folder` is where its image is looked for.

    Raises: WorldFileError naming `source`, line and key.
    """
    document = read_yaml(text, source)
    keys = document.mapping(KEYS, required=("image", "resolution", "origin"))
    resolution = keys["resolution"].number(1e-4, 100.0)
    x, y, yaw = keys["origin"].numbers(3)
    image = read_bitmap(folder / keys["image"].text())
    mode = keys["mode"].one_of(MODES) if "mode" in keys else "trinary"
    occupied_above = keys["occupied_thresh"].number(0.0, 1.0) if "occupied_thresh" in keys else 0.65
    free_below = keys["free_thresh"].number(0.0, 1.0) if "free_thresh" in keys else 0.196
    if free_below > occupied_above:
        raise keys.get("free_thresh", document).error(f"{free_below:g} is above occupied_thresh")
    free = free_cells(image, mode, occupied_above, free_below, _negate(keys))
    area = largest_area(free)
    if not area.any():
        raise document.error("the map has no free cell")
    shapes = _shapes(area, resolution, (x, y, yaw))
    spec = WorldSpec(name, shapes, description=f"imported from the ROS map {Path(source).name}")
    return require_start(with_starts(scaled(spec, scale)), source)


def _negate(keys: dict[str, Entry]) -> bool:
    return "negate" in keys and keys["negate"].one_of(("0", "1", "true", "false")) in ("1", "true")


def free_cells(image: Gray, mode: str, occupied_above: float, free_below: float, negate: bool) -> Mask:
    """Which cells (rows, columns), row 0 on top, are free.

    trinary: those whose occupancy is below `free_below`, but not those of the gray that map savers write
    for unknown: it lies between the old default threshold (0.196) and the new one (0.25). scale: also those
    in between whose share of the way to `occupied_above` is under a half. raw: those whose value, in percent,
    is below `free_below`. Cells never seen count as free where they are specks among free ones.
    """
    if mode == "raw":
        percent = np.round(image * 255.0)
        occupied = (percent > occupied_above * 100.0) & (percent <= 100.0)
        return _with_specks(percent < free_below * 100.0, occupied)
    occupancy = image if negate else 1.0 - image
    occupied = occupancy > occupied_above
    if mode == "scale" and occupied_above > free_below:
        return _with_specks((occupancy - free_below) / (occupied_above - free_below) < 0.5, occupied)
    free = occupancy < free_below
    known = free & (np.round(image * 255.0) != UNKNOWN)
    return _with_specks(known if known.any() else free, occupied)


def _with_specks(free: Mask, occupied: Mask) -> Mask:
    """The free cells and those never seen that lie in patches thinner than SPECK cells: shadows of rays."""
    solid = np.pad(~free, SPECK, constant_values=True)
    height, width = solid.shape
    spots = [(row, column) for row in range(SPECK) for column in range(SPECK)]
    kernel = np.ones((height - SPECK + 1, width - SPECK + 1), dtype=bool)
    for row, column in spots:
        kernel &= solid[row : row + kernel.shape[0], column : column + kernel.shape[1]]
    thick = np.zeros(solid.shape, dtype=bool)
    for row, column in spots:
        thick[row : row + kernel.shape[0], column : column + kernel.shape[1]] |= kernel
    return ~(occupied | thick[SPECK:-SPECK, SPECK:-SPECK])


def largest_area(free: Mask) -> Mask:
    """The largest set of free cells that hang together by their sides."""
    labels = np.zeros(free.shape, dtype=np.int64)
    parents = [0]

    def root(label: int) -> int:
        while parents[label] != label:
            parents[label] = parents[parents[label]]
            label = parents[label]
        return label

    before: list[tuple[int, int, int]] = []
    for row in range(len(free)):
        current = []
        for begin, end in _runs(free[row]):
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
    merged = roots[labels]
    sizes = np.bincount(merged[free], minlength=1)
    area: Mask = free & (merged == int(sizes.argmax()))
    return area


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


def _shapes(area: Mask, resolution: float, origin: tuple[float, float, float]) -> tuple[Shape, ...]:
    padded = np.pad(area, RIM)
    rows, columns = np.flatnonzero(padded.any(axis=1)), np.flatnonzero(padded.any(axis=0))
    top, bottom = int(rows[0]) - RIM, int(rows[-1]) + RIM + 1
    left, right = int(columns[0]) - RIM, int(columns[-1]) + RIM + 1
    solid = ~padded[top:bottom, left:right]
    rectangles = min((merge_cells(solid), _flipped(merge_cells(solid.T))), key=len)
    if len(rectangles) > MAX_BOXES:
        raise WorldFileError(f"the map needs {len(rectangles)} boxes, more than the limit of {MAX_BOXES}")
    x, y, yaw = origin
    cosine, sine = math.cos(yaw), math.sin(yaw)
    height = len(padded)
    shapes = []
    for row, column, deep, wide in rectangles:
        along = (left + column + wide / 2 - RIM) * resolution
        up = (height - (top + row + deep / 2) - RIM) * resolution
        place = x + cosine * along - sine * up, y + sine * along + cosine * up
        shapes.append(Box(*place, wide * resolution, deep * resolution, yaw))
    return tuple(shapes)


def _flipped(rectangles: list[tuple[int, int, int, int]]) -> list[tuple[int, int, int, int]]:
    return [(column, row, wide, deep) for row, column, deep, wide in rectangles]
