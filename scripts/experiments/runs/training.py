"""A mapping that trains the SOMs of its local maps in every configuration of table 4.8."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ....agent.goals import LocalSamples
from ....maps.local.config import DEFAULT, THESIS_1
from ....maps.local.local_map import LocalMap
from ....maps.som.som import SOM
from ...session.mapping import Mapping
from ...session.profiles import THESIS_LOCAL_MAP

if TYPE_CHECKING:
    from ...session.map_files import MapWriter
    from ...session.requests import MapRequest
    from ...session.stage import Stage

CONFIGURATIONS = {"batch": DEFAULT, "configuration 1": THESIS_1, "configuration 2": THESIS_LOCAL_MAP}
METRIC_SIZES = (3, 5, 10)
EXAMPLES = 4


@dataclass(frozen=True, slots=True)
class Fit:
    """A self-organizing map trained in one configuration. data: (n, values); seconds: of processor time."""

    configuration: str
    som: SOM
    data: NDArray[np.float64]
    seconds: float
    metric: bool
    standard: bool
    """Whether it has the size that local maps have."""


def fits(samples: LocalSamples, seed: int, node: int) -> list[Fit]:
    """Both SOMs trained on one local map's samples in every configuration, metric ones in several sizes."""
    places = samples.positions / DEFAULT.size + 0.5
    views = samples.panoramas.reshape(len(samples.panoramas), -1).astype(np.float64)
    found = []
    for name, config in CONFIGURATIONS.items():
        todo = [(places, size, config.metric) for size in METRIC_SIZES]
        todo += [(views, config.rows, config.perceptual)] if len(views) else []
        for data, size, schedule in todo:
            random = np.random.default_rng(np.random.SeedSequence([seed, node]))
            began = time.process_time()
            som = SOM(size, size, config.topology).fit(data, schedule, random)
            seconds = time.process_time() - began
            found.append(Fit(name, som, data, seconds, data is places, size == config.rows))
    return found


def training(found: Sequence[Fit]) -> dict[str, Any]:
    """What each fit took: steps, seconds, quantization error.

    Seconds are of processor time, so that a busy machine does not count; they are the only figures of an
    experiment that differ from run to run.
    """
    return {_label(fit): _figures(fit) | ({"unit": DEFAULT.size} if fit.metric else {}) for fit in found}


def _label(fit: Fit) -> str:
    size = "" if fit.standard else f" {_size(fit)}"
    return f"{fit.configuration}, {'metric' if fit.metric else 'perceptual'}{size}"


def _size(fit: Fit) -> str:
    side = math.isqrt(len(fit.som.weights))
    return f"{side}x{side}"


def _figures(fit: Fit) -> dict[str, Any]:
    assert fit.som.training is not None
    return {
        "steps": fit.som.training.steps,
        "converged": fit.som.training.converged,
        "seconds": fit.seconds,
        "error": fit.som.quantization_error(fit.data),
        "used": len(set(fit.som.winners(fit.data).tolist())),
        "samples": len(fit.data),
    }


def example(samples: LocalSamples, found: Sequence[Fit], node: int) -> dict[str, Any]:
    """One local map's samples and what every configuration makes of them, to draw (figures 4.7, 4.9 to 4.11).

    positions, views: (n, 2) m, local frame. metric: weights (units, 2) m by configuration and size.
    perceptual: the unit of each view, by configuration; all as JSON values.
    """
    metric = [fit for fit in found if fit.metric and (fit.standard or fit.configuration == "batch")]
    return {
        "node": node,
        "positions": np.round(samples.positions, 4).tolist(),
        "views": np.round(samples.panorama_positions, 4).tolist(),
        "metric": {
            f"{fit.configuration}, {_size(fit)}": np.round((fit.som.weights - 0.5) * DEFAULT.size, 4).tolist()
            for fit in metric
        },
        "perceptual": {
            fit.configuration: fit.som.winners(fit.data).tolist() for fit in found if not fit.metric
        },
    }


class TrainingMapping(Mapping):
    """A mapping that also trains every configuration of table 4.8 on what each local map was made of."""

    def __init__(
        self, stage: Stage, request: MapRequest, robot: int = 0, writer: MapWriter | None = None
    ) -> None:
        """As any mapping. trained: by local map; examples: of the first local maps."""
        super().__init__(stage, request, robot, writer)
        self.trained: list[dict[str, Any]] = []
        self.examples: list[dict[str, Any]] = []

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains all of them too."""
        node = self.mapper.current
        found = fits(samples, self.request.seed, node)
        if len(self.examples) < EXAMPLES:
            self.examples.append(example(samples, found, node))
        self.trained.append(training(found))
        return super().build(samples, entry_heading)
