"""What an experiment watches in a mapping run: laps, path integration, local exploration, SOM training.

Probes know the truth. They only look on, but for the lap's: profile `thesis` cannot tell that it has been
round without local maps, so the experiment ends its run after a lap.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from ....agent.behavior import Context
from ....agent.events import BehaviorFinished, BehaviorStarted, NodeCommitted, NodeCreated
from ....agent.goals import ExploreLocally, LocalSamples
from ....agent.mapping.published import ThesisMapper
from ....maps.local.local_map import LocalMap
from ....maps.local.training import DEFAULT, THESIS_1, LocalMapConfig
from ....maps.som.som import SOM
from ....world.robot import Percept, Pose, wrap_angle
from ...session.mapping_run import MappingRun
from ...session.profiles import THESIS_LOCAL_MAP

AT_NODE = 0.15
"""Meters from where a node is within which a robot is at it."""
_AWAY, _CLOSE, _PAST = 0.40, 0.08, 0.03
"""Meters from node 0: a lap has begun; a node is as good as there; past it."""
_SAME_WAY = math.radians(60.0)
CONFIGURATIONS = {"batch": DEFAULT, "configuration 1": THESIS_1, "configuration 2": THESIS_LOCAL_MAP}
METRIC_SIZES = (3, 5, 10)
EXAMPLES = 4


class LapProbe:
    """Notices when the robot has truly been round, and the error of path integration there.

    error: distance (m) between the integrated and the true position, nearest to node 0 after one lap. Ends a
    run of profile `thesis` at the node that it commits nearest to node 0, or once it is past it.
    """

    def __init__(self, run: MappingRun) -> None:
        """Adds itself to the run's agent."""
        self.error: float | None = None
        self.estimates: dict[int, tuple[float, float]] = {}
        self._run = run
        self._left = False
        self._nearest = math.inf
        self._at_home = False
        run.agent.attach(self)
        run.agent.bus.subscribe(NodeCreated, self._on_created)
        run.agent.bus.subscribe(NodeCommitted, self._on_committed)

    def update(self, percept: Percept, context: Context) -> None:
        """Called once a tick, after path integration."""
        run = self._run
        home = run.truth.get(0)
        # Exploring around a node across a passage may come near node 0 too: that is no lap.
        if home is None or run.mapper.done or run.agent.is_active("local-exploration"):
            return
        pose = run.world.true_pose()
        distance = pose.distance_to(home)
        self._left = self._left or distance > _AWAY
        if self._at_home and distance > self._nearest + _PAST:
            self._stop()
        if not self._left or abs(wrap_angle(pose.heading - home.heading)) > _SAME_WAY:
            return
        if distance < min(self._nearest, AT_NODE):
            self._nearest = distance
            self.error = run.raw.pose.distance_to(pose)

    def _on_created(self, event: NodeCreated) -> None:
        pose = self._run.raw.pose
        self.estimates[event.node] = (pose.x, pose.y)

    def _on_committed(self, event: NodeCommitted) -> None:
        """Takes the last node within reach of node 0 for the lap's end, or else the first one past it."""
        home = self._run.truth.get(0)
        if home is None or self.error is None:
            return
        distance = self._run.truth[event.node].distance_to(home)
        self._at_home = distance <= AT_NODE
        if distance <= _CLOSE or self._run.world.true_pose().distance_to(home) > self._nearest + _PAST:
            self._stop()

    def _stop(self) -> None:
        if isinstance(self._run.mapper, ThesisMapper):
            self._run.mapper.stop("lap")


class ExplorationProbe:
    """Errors left by exploring a local map: true position (m) and heading (rad) before and after it.

    after: when local exploration is over; docked: when the node is complete, corrected if the profile does.
    """

    def __init__(self, run: MappingRun) -> None:
        """Subscribes to the run's agent."""
        self.after: list[tuple[float, float]] = []
        self.docked: list[tuple[float, float]] = []
        self._run = run
        self._before: Pose | None = None
        bus = run.agent.bus
        bus.subscribe(BehaviorStarted, self._on_started)
        bus.subscribe(BehaviorFinished, self._on_finished)
        bus.subscribe(NodeCommitted, self._on_committed)

    def _on_started(self, event: BehaviorStarted) -> None:
        if event.behavior == "local-exploration" and isinstance(event.goal, ExploreLocally):
            pose = self._run.world.true_pose()
            # The robot may stand askew and know it: exploring ends in the entry heading all the same.
            self._before = Pose(pose.x, pose.y, pose.heading - event.goal.heading)

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior == "local-exploration":
            self._note(self.after)

    def _on_committed(self, event: NodeCommitted) -> None:
        self._note(self.docked)
        self._before = None

    def _note(self, errors: list[tuple[float, float]]) -> None:
        if self._before is not None:
            pose = self._run.world.true_pose()
            turn = abs(wrap_angle(pose.heading - self._before.heading))
            errors.append((pose.distance_to(self._before), turn))


def training(samples: LocalSamples, seed: int, node: int) -> dict[str, Any]:
    """Trains both SOMs on one local map's samples in every configuration: steps, seconds, quantization error.

    Seconds are of processor time, so that a busy machine does not count; they are the only figures of an
    experiment that differ from run to run.
    """
    places = samples.positions / DEFAULT.size + 0.5
    views = samples.panoramas.reshape(len(samples.panoramas), -1).astype(np.float64)
    found: dict[str, Any] = {}
    for name, config in CONFIGURATIONS.items():
        for size in METRIC_SIZES:
            kind = "metric" if size == config.rows else f"metric {size}x{size}"
            found[f"{name}, {kind}"] = _trained(places, config, size, "metric", (seed, node)) | {
                "unit": DEFAULT.size
            }
        if len(views):
            found[f"{name}, perceptual"] = _trained(views, config, config.rows, "perceptual", (seed, node))
    return found


def example(samples: LocalSamples, seed: int, node: int) -> dict[str, Any]:
    """One local map's samples and what every configuration makes of them, to draw (figures 4.7, 4.9 to 4.11).

    positions, views: (n, 2) m, local frame. metric: weights (units, 2) m by configuration and size.
    perceptual: the unit of each view, by configuration; all as JSON values.
    """
    places = samples.positions / DEFAULT.size + 0.5
    views = samples.panoramas.reshape(len(samples.panoramas), -1).astype(np.float64)
    metric, perceptual = {}, {}
    for name, config in CONFIGURATIONS.items():
        for size in METRIC_SIZES if name == "batch" else (config.rows,):
            random = np.random.default_rng(np.random.SeedSequence([seed, node]))
            som = SOM(size, size, config.topology).fit(places, config.metric, random)
            metric[f"{name}, {size}x{size}"] = np.round((som.weights - 0.5) * DEFAULT.size, 4).tolist()
        if len(views):
            random = np.random.default_rng(np.random.SeedSequence([seed, node]))
            som = SOM(config.rows, config.cols, config.topology).fit(views, config.perceptual, random)
            perceptual[name] = som.winners(views).tolist()
    return {
        "node": node,
        "positions": np.round(samples.positions, 4).tolist(),
        "views": np.round(samples.panorama_positions, 4).tolist(),
        "metric": metric,
        "perceptual": perceptual,
    }


def _trained(
    data: np.ndarray[Any, np.dtype[np.float64]],
    config: LocalMapConfig,
    size: int,
    part: str,
    seed: tuple[int, int],
) -> dict[str, Any]:
    random = np.random.default_rng(np.random.SeedSequence(list(seed)))
    began = time.process_time()
    som = SOM(size, size, config.topology).fit(data, getattr(config, part), random)
    seconds = time.process_time() - began
    assert som.training is not None
    winners = set(som.winners(data).tolist())
    return {
        "steps": som.training.steps,
        "converged": som.training.converged,
        "seconds": seconds,
        "error": som.quantization_error(data),
        "used": len(winners),
        "samples": len(data),
    }


class TrainingRun(MappingRun):
    """A mapping that also trains every configuration of table 4.8 on what each local map was made of."""

    trained: list[dict[str, Any]]
    examples: list[dict[str, Any]]
    """Of the first local maps."""

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains all of them too."""
        if not hasattr(self, "trained"):
            self.trained, self.examples = [], []
        if len(self.examples) < EXAMPLES:
            self.examples.append(example(samples, self.request.seed, self.mapper.current))
        self.trained.append(training(samples, self.request.seed, self.mapper.current))
        return super().build(samples, entry_heading)
