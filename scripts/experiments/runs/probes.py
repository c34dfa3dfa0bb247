"""What an experiment watches in a mapping run: laps, path integration, local exploration.

Probes know the truth. They only look on, but for the lap's: profile `thesis` cannot tell that it has been
round without local maps, so the experiment ends its run after a lap.
"""

from __future__ import annotations

import math

from ....agent.behavior import Context
from ....agent.events import BehaviorFinished, BehaviorStarted, NodeCommitted, NodeCreated
from ....agent.goals import ExploreLocally
from ....agent.mapping.published import ThesisMapper
from ....world.robot import Percept, Pose, wrap_angle
from ...session.mapping import Mapping

AT_NODE = 0.15
"""Meters from where a node is within which a robot is at it."""
_AWAY, _CLOSE, _PAST = 0.40, 0.08, 0.03
"""Meters from node 0: a lap has begun; a node is as good as there; past it."""
_SAME_WAY = math.radians(60.0)


class LapProbe:
    """Notices when the robot has truly been round, and the error of path integration there.

    error: distance (m) between the integrated and the true position, nearest to node 0 after one lap. Ends a
    run of profile `thesis` at the node that it commits nearest to node 0, or once it is past it.
    """

    def __init__(self, run: Mapping) -> None:
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
        home = run.observer.nodes.get(0)
        # Exploring around a node across a passage may come near node 0 too: that is no lap.
        if home is None or run.mapper.done or run.agent.is_active("local-exploration"):
            return
        pose = run.observer.pose
        distance = pose.distance_to(home)
        self._left = self._left or distance > _AWAY
        if self._at_home and distance > self._nearest + _PAST:
            self._stop()
        if not self._left or abs(wrap_angle(pose.heading - home.heading)) > _SAME_WAY:
            return
        if distance < min(self._nearest, AT_NODE):
            self._nearest = distance
            self.error = run.observer.raw.pose.distance_to(pose)

    def _on_created(self, event: NodeCreated) -> None:
        pose = self._run.observer.raw.pose
        self.estimates[event.node] = (pose.x, pose.y)

    def _on_committed(self, event: NodeCommitted) -> None:
        """Takes the last node within reach of node 0 for the lap's end, or else the first one past it."""
        home = self._run.observer.nodes.get(0)
        if home is None or self.error is None:
            return
        distance = self._run.observer.nodes[event.node].distance_to(home)
        self._at_home = distance <= AT_NODE
        if distance <= _CLOSE or self._run.observer.pose.distance_to(home) > self._nearest + _PAST:
            self._stop()

    def _stop(self) -> None:
        if isinstance(self._run.mapper, ThesisMapper):
            self._run.mapper.stop("lap")


class ExplorationProbe:
    """Errors left by exploring a local map: true position (m) and heading (rad) before and after it.

    after: when local exploration is over; docked: when the node is complete, corrected if the profile does.
    """

    def __init__(self, run: Mapping) -> None:
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
            pose = self._run.observer.pose
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
            pose = self._run.observer.pose
            turn = abs(wrap_angle(pose.heading - self._before.heading))
            errors.append((pose.distance_to(self._before), turn))
