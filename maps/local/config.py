"""How local maps are built: the settings, and those of the profiles (tables 4.7 and 4.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..som.lattice import Topology
from ..som.schedules import BATCH, METRIC_1, METRIC_2, PERCEPTUAL_1, PERCEPTUAL_2, Config
from ..som.som import Method


@dataclass(frozen=True, slots=True)
class LocalMapConfig:
    """How a local map is built. size: side (m) of the square local space, centered on the node.

    association: how positions are tied to perceptual units, `midpoint` (eq. 3.32: the last sample weighs
    half) or `mean`. locating: how a position is estimated from a view (see `SOM.locate`). grounded: whether
    metric units that samples hit are kept to where the body has been (see `grounded`).
    """

    rows: int = 5
    cols: int = 5
    topology: Topology = "hexagonal"
    size: float = 0.25
    metric: Config = BATCH
    perceptual: Config = BATCH
    association: Literal["mean", "midpoint"] = "mean"
    locating: Method = "radial"
    grounded: bool = True


DEFAULT = LocalMapConfig()
"""Profile `default`."""

THESIS_1 = LocalMapConfig(
    metric=METRIC_1, perceptual=PERCEPTUAL_1, association="midpoint", locating="best", grounded=False
)
"""Tables 4.7 and 4.8, configuration 1."""

THESIS_2 = LocalMapConfig(
    metric=METRIC_2, perceptual=PERCEPTUAL_2, association="midpoint", locating="best", grounded=False
)
"""Tables 4.7 and 4.8, configuration 2, the one the thesis finds the better."""
