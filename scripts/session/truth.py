"""What truly happens to a robot, and the truth section of a map file: to score, to save and to draw.

Only scripts/ know it; the agent and its HybridMap never do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...agent import Agent, PathIntegrator
from ...agent.events import CornerReached, NodeCreated
from ...maps.errors import MapFileDamagedError
from ...maps.storage.map_file import RUN, Truth, read_truth
from ...world.robot import Percept, Pose

if TYPE_CHECKING:
    from ...agent import Context
    from ...world import World

TRACK_STEP = 0.01
"""Meters between two points of a track that is kept."""


class Observer:
    """Watches where one robot truly is: at corners, at the nodes made of them, and on its way.

    nodes: node -> true pose of the robot where it met its corner, heading = that of the wall before it. raw:
    path integration from the true pose at the start on, by the encoders alone. track: where it went while a
    mapping is under way, m.
    """

    def __init__(self, world: World, agent: Agent, robot: int = 0) -> None:
        """Watches from now on. robot: the agent's, among those of the world."""
        self.nodes: dict[int, Pose] = {}
        self.track: list[tuple[float, float]] = []
        self.raw = PathIntegrator(world.robots[robot].geometry, world.true_pose(robot))
        self._world, self._agent, self._robot = world, agent, robot
        self._mapping = False
        self._corners: dict[int, Pose] = {}
        self._percept: Percept | None = None
        agent.attach(self)
        agent.bus.subscribe(CornerReached, self._on_corner)
        agent.bus.subscribe(NodeCreated, self._on_node)

    @property
    def pose(self) -> Pose:
        """Where the robot truly is, world frame (m, rad)."""
        return self._world.true_pose(self._robot)

    def begin(self) -> None:
        """A mapping begins: corners and the way to them are kept from now on; what was is forgotten."""
        self._mapping = True
        self.nodes, self.track, self._corners = {}, [], {}

    def end(self) -> None:
        """The mapping is over: nothing more is kept but the nodes there are."""
        self._mapping = False

    def corner(self, event: CornerReached) -> Pose:
        """Where the robot truly met a corner, turned by what it believes to be askew to the wall.

        It is noted in the tick in which the corner is met, whoever hears of it first.
        """
        if event.number not in self._corners:
            pose = self.pose
            skew = self._agent.odometry.heading - event.heading
            self._corners[event.number] = Pose(pose.x, pose.y, pose.heading - skew)
        return self._corners[event.number]

    def met(self, corner: int) -> Pose:
        """The same of a corner that was met before, by its number."""
        return self._corners[corner]

    def commit(self, node: int, corner: CornerReached) -> None:
        """The corner is, for good, a node of the map."""
        self.nodes[node] = self.corner(corner)

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly, as JSON."""
        nodes = {str(node): [pose.x, pose.y, pose.heading] for node, pose in self.nodes.items()}
        return {"raw": self.raw.state(), "truth": nodes}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        if "raw" in state:  # not in a journal of before
            self.raw.restore(state["raw"])
        self.nodes = {int(node): Pose(*pose) for node, pose in state["truth"].items()}
        self.track = [(x, y) for x, y in state.get("track", ())]

    # --- called by the session and the agent -------------------------------------------------------------

    def update(self, percept: Percept, context: Context) -> None:
        """Called by the agent once a tick."""
        self._percept = percept

    def ticked(self) -> None:
        """Called when the robot's agent has done its tick."""
        if self._percept is not None:
            self.raw.update(self._percept.encoders)

    def stepped(self) -> None:
        """Called when the world has gone on by a tick."""
        if not self._mapping:
            return
        pose, track = self.pose, self.track
        if is_known(pose) and (
            not track or abs(pose.x - track[-1][0]) + abs(pose.y - track[-1][1]) > TRACK_STEP
        ):
            track.append((pose.x, pose.y))

    def _on_corner(self, event: CornerReached) -> None:
        if self._mapping:
            self.corner(event)

    def _on_node(self, event: NodeCreated) -> None:
        if event.met in self._corners:
            self.nodes[event.node] = self._corners[event.met]


# --- the truth section of a map file ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class TrueRun:
    """nodes: true pose of each node at its commit, heading = entry heading. track: (n, 2) m. World frame."""

    nodes: Mapping[int, Pose]
    track: NDArray[np.float64]


def node_truth(pose: Pose, track: Iterable[tuple[float, float]]) -> dict[str, Any]:
    """What is kept with one node, as JSON: its true pose (m, rad) and the track since the node before (m).

    Rounded to 0.1 mm and 1e-6 rad: enough to draw and to score, and short. Nothing where nobody knows it.
    """
    if not is_known(pose):
        return {}
    return {
        "pose": [round(pose.x, 6), round(pose.y, 6), round(pose.heading, 6)],
        "track": _short(track),
    }


def run_truth(track: Iterable[tuple[float, float]], pose: Pose | None = None) -> dict[str, Any]:
    """What is kept about a run as a whole, as JSON: the track (m) after its last node, and where it ended."""
    where = {} if pose is None or not is_known(pose) else {"pose": [pose.x, pose.y, pose.heading]}
    return {"track": _short(track), **where}


def is_known(pose: Pose) -> bool:
    """Whether it is a pose at all: that of a real robot is not a number."""
    return math.isfinite(pose.x)


def map_truth(observer: Observer, nodes: Iterable[int]) -> dict[int, dict[str, Any]]:
    """The rows of a map that is saved as a whole: where its nodes are and where the robot is, no track."""
    rows = {node: node_truth(observer.nodes[node], ()) for node in nodes if node in observer.nodes}
    return {**{node: row for node, row in rows.items() if row}, RUN: run_truth((), observer.pose)}


def poses_of(truth: Truth) -> dict[int, Pose]:
    """The true pose of each node that a file's truth section knows (m, rad, world frame)."""
    return {node: Pose(*map(float, record["pose"])) for node, record in truth.nodes.items()}


def read_map_truth(path: Path) -> TrueRun | None:
    """The truth that a map file has, or None if it has none (a map by a real robot, an imported one).

    Raises: MapError if the file cannot be read.
    """
    truth = read_truth(path)
    try:
        nodes = poses_of(truth)
        if not nodes:
            return None
        records = [*(truth.nodes[node] for node in sorted(nodes)), truth.run]
        pieces = [np.array(record.get("track", []), dtype=float).reshape(-1, 2) for record in records]
    except (KeyError, TypeError, ValueError, OverflowError):
        raise MapFileDamagedError(f"{path}: its true poses and tracks are not well-formed") from None
    return TrueRun(nodes, np.concatenate(pieces))


def _short(track: Iterable[tuple[float, float]]) -> list[list[float]]:
    return [[round(float(x), 4), round(float(y), 4)] for x, y in track]
