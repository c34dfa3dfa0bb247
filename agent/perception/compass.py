"""A visual compass: by how much a panorama is turned against another of the same place, and how unlike it is.

Good to 0.4 deg (median, white walls) on the spot; near walls parallax spoils it: 1 deg at 2 cm, 4 at 4 cm.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_RANGE = math.radians(20.0)
_STEP = math.radians(0.5)
_LEAST_SHARPNESS = 0.1
"""Less comes of plain views, whose differences are rounding; among real walls it is 0.2 and more."""


_ALIKE = math.radians(8.0)
"""Two panoramas of one place, each taken on arrival at it, are turned against each other by less (rad)."""


class Turn(NamedTuple):
    """angle: rad, counter-clockwise, of the view against the reference. sharpness: 0 is not sure at all."""

    angle: float
    sharpness: float


@lru_cache(maxsize=8)
def _shifts(width: int, field: float) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]:
    """Candidate turns (k,), each as weights (k, width, width) on a reference's columns, valid (k, width)."""
    turns = np.arange(-_RANGE, _RANGE + 0.5 * _STEP, _STEP)
    focal = 0.5 * width / math.tan(0.5 * field)
    columns = np.arange(width)
    bearing = np.arctan((0.5 * width - columns - 0.5) / focal)
    seen = bearing[None, :] + turns[:, None]
    source = 0.5 * width - 0.5 - focal * np.tan(seen)
    valid = (source >= 0.0) & (source <= width - 1.0)
    low = np.clip(np.floor(source).astype(int), 0, width - 2)
    share = np.clip(source - low, 0.0, 1.0)
    weights = np.zeros((len(turns), width, width), dtype=np.float32)
    k, u = np.indices(source.shape)
    weights[k, u, low] = 1.0 - share
    weights[k, u, low + 1] += share
    return turns, weights, valid.astype(np.float32)


def _costs(
    reference: NDArray[np.float32], view: NDArray[np.float32], field: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Candidate turns (k,) rad; squared differences (k, 4) summed by view; pixels (k,) they are of."""
    turns, weights, valid = _shifts(reference.shape[2], field)
    shifted = np.einsum("kuc,vhc->kvhu", weights, reference, optimize=True)
    squares = ((shifted - view[None]) ** 2).sum(axis=2)
    return turns, (squares * valid[:, None, :]).sum(axis=2), valid.sum(axis=1) * reference.shape[1]


def turn_between(reference: NDArray[np.float32], view: NDArray[np.float32], field: float) -> Turn | None:
    """How far `view` is turned against `reference`, (4, height, width) panoramas; None if they do not tell.

    field: the camera's horizontal field of view (rad). The four directions are shifted together; the turn
    with the least mean squared difference over the columns that both see is taken, to a part of a step.
    """
    turns, squares, pixels = _costs(reference, view, field)
    cost = squares.sum(axis=1) / (pixels * reference.shape[0])
    best = int(np.argmin(cost))
    if best in (0, len(turns) - 1):
        return None
    before, here, after = float(cost[best - 1]), float(cost[best]), float(cost[best + 1])
    bend = before - 2.0 * here + after
    if bend <= 0.0:
        return None
    sharpness = float(np.median(cost)) / (here + 1e-9) - 1.0
    if sharpness < _LEAST_SHARPNESS:
        return None
    offset = 0.5 * (before - after) / bend
    return Turn(float(turns[best]) + offset * _STEP, sharpness)


def difference(
    reference: NDArray[np.float32], view: NDArray[np.float32], field: float, most: float = _ALIKE
) -> float:
    """Root mean square of the luminances by which two panoramas differ, each view turned as fits it best.

    Shapes and field as for `turn_between`; most: to turn by, rad. The robot turned between the views, not
    exactly by quarters, so each has its own turn.
    """
    turns, squares, pixels = _costs(reference, view, field)
    near = np.abs(turns) <= most
    return math.sqrt(float((squares[near] / pixels[near, None]).min(axis=0).mean()))


def sensitivity(reference: NDArray[np.float32], field: float, turn: float) -> float:
    """Root mean square of the luminances by which a panorama differs from itself turned by `turn` (rad)."""
    turns, squares, pixels = _costs(reference, reference, field)
    k = int(np.abs(turns - turn).argmin())
    return math.sqrt(float(squares[k].mean() / pixels[k]))
