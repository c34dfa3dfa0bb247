"""How a SOM is trained, as plain data: the thesis's two configurations and our batch default.

Slips of table 4.8/4.9 and how they are read here: the power series runs to T (the table hard-codes 1000
where the perceptual T is 500); configuration 2's least rate is the 0.01 that table 4.9 goes on with; sigma(t)
shrinks by the same power series to 0.3; "average delta" is the mean length of a unit's move in a step, over
one pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import MapError

if TYPE_CHECKING:
    from .lattice import Floats

Start = Literal["pca", "grid", "random", "samples"]


@dataclass(frozen=True, slots=True)
class OnlineConfig:
    """Online training (section 3.4.3): one sample a step, in random order or in sequence.

    steps: the ordering phase T. rate: alpha_0. rate_end: what the decay aims at. rate_after: the rate from T
    on. radius: sigma_0 for "gaussian", lattice steps for "bubble" (within T; the winner alone after it).
    stop_delta: stop once the mean move of a unit in a step, over one pass, is below. max_steps: the cap.
    """

    steps: int = 1000
    rate: float = 0.4
    rate_end: float = 0.1
    rate_after: float = 0.01
    decay: Literal["linear", "power", "inverse"] = "linear"
    neighborhood: Literal["bubble", "gaussian"] = "bubble"
    radius: float = 1.0
    radius_end: float = 0.3
    start: Start = "grid"
    start_range: tuple[float, float] = (-0.3, 0.3)
    order: Literal["random", "sequence"] = "random"
    stop_delta: float = 1e-8
    max_steps: int = 5000

    def __post_init__(self) -> None:
        """Checks the numbers. Raises: MapError."""
        if self.steps < 1 or self.max_steps < 1:
            raise MapError(
                f"training of {self.steps} steps, at most {self.max_steps}: both must be at least 1"
            )
        if not 0.0 < self.rate <= 1.0 or not 0.0 < self.rate_end <= 1.0 or not 0.0 <= self.rate_after <= 1.0:
            raise MapError("learning rates must lie in (0, 1]")
        _check_radii(self.radius or 1.0, self.radius_end)  # 0: the winner alone moves

    def rates(self) -> Floats:
        """(max_steps,) the learning rate at each step (table 4.9; eq. 3.23)."""
        t = np.arange(self.max_steps, dtype=np.float64)
        if self.decay == "inverse":
            return self.rate / (1.0 + t / (self.steps / 2.0))
        fraction = t / self.steps
        if self.decay == "linear":
            during = self.rate - (self.rate - self.rate_end) * fraction
        else:
            during = self.rate * (self.rate_end / self.rate) ** fraction
        return np.where(t < self.steps, during, self.rate_after)

    def radii(self) -> Floats:
        """(max_steps,) the neighborhood's radius at each step, in lattice units."""
        t = np.arange(self.max_steps, dtype=np.float64)
        if self.neighborhood == "bubble":
            return np.where(t < self.steps, self.radius, 0.0)
        if self.decay == "inverse":
            return self.radius / (1.0 + t / (self.steps / 2.0))
        fraction = np.minimum(t / self.steps, 1.0)
        return np.asarray(self.radius * (self.radius_end / self.radius) ** fraction, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class BatchConfig:
    """Batch training: every pass moves each unit to the weighted mean of all samples.

    The Gaussian radius shrinks geometrically from `radius` to `radius_end` in `passes` passes, then stays
    until the best-matching units repeat, for at most `max_passes` in all. starts: from how many turned planes
    at once, of which the best is kept (start "pca" alone). fill: dead units, left without samples, then
    take over samples that share one (see `dead_units`).
    """

    passes: int = 12
    radius: float = 3.0
    radius_end: float = 0.3
    start: Start = "pca"
    starts: int = 4
    start_range: tuple[float, float] = (-0.3, 0.3)
    max_passes: int = 60
    fill: bool = True

    def __post_init__(self) -> None:
        """Checks the numbers. Raises: MapError."""
        if self.passes < 1 or self.max_passes < self.passes:
            raise MapError(
                f"{self.passes} passes of at most {self.max_passes}: at least 1, and no more than the cap"
            )
        _check_radii(self.radius, self.radius_end)
        if not 1 <= self.starts <= 4:
            raise MapError(f"{self.starts} starts: from 1 to 4")

    def radii(self) -> Floats:
        """(passes,) the Gaussian radius of each pass, in lattice units."""
        if self.passes == 1:
            return np.array([self.radius_end])
        return np.geomspace(self.radius, self.radius_end, self.passes)


def _check_radii(*radii: float) -> None:
    if not all(0.0 < radius < math.inf for radius in radii):
        raise MapError("the neighborhood's radius must be positive and finite")


Config = OnlineConfig | BatchConfig

BATCH = BatchConfig()
"""Our default."""

METRIC_1 = OnlineConfig()
"""Table 4.8, metric SOM, configuration 1: bubble and linear rate, from a uniform grid."""

METRIC_2 = OnlineConfig(rate=0.1, rate_end=0.01, decay="power", neighborhood="gaussian", radius=3.0)
"""Table 4.8, metric SOM, configuration 2: Gaussian and power series, from a uniform grid."""

PERCEPTUAL_1 = OnlineConfig(steps=500, rate=0.7, start="random", stop_delta=1e-6)
"""Table 4.8, perceptual SOM, configuration 1: bubble and linear rate, from U(-0.3, 0.3)."""

PERCEPTUAL_2 = OnlineConfig(
    steps=500,
    rate=0.3,
    rate_end=0.01,
    decay="power",
    neighborhood="gaussian",
    radius=3.0,
    start="random",
    stop_delta=1e-6,
)
"""Table 4.8, perceptual SOM, configuration 2: Gaussian and power series, from U(-0.3, 0.3)."""
