"""Navigation within a node's local map, from unit to unit of its metric SOM (section 3.5.3)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...maps.errors import MapError
from ...world.robot import Pose
from ..boundary.trace import ClosingConfig
from ..estimation.landmarks import VANTAGE_POINT
from ..estimation.local_filter import LocalPose
from ..events import BehaviorFinished
from ..goals import DrivePath, PlacesDriven
from ..listener import Listener
from ..walls import WALL_DISTANCE, walls_at

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent


class LocalNavigator(Listener):
    """Takes the robot through a node's local map, from unit to unit of its metric SOM, by `local-go-to`.

    pose: where it holds the robot to be in the local frame; it begins in the transition pose. An edge on
    which an obstacle is met is remembered as blocked in the map, and another way is looked for. The walls at
    the node keep the pose: when it has become doubtful, and on the way home, it goes where they can be seen.
    """

    def __init__(self, agent: Agent, hybrid_map: HybridMap, node: int, *, landmarks: bool = True) -> None:
        """landmarks: False keeps to path integration. Raises: MapError if the node has no local map."""
        local_map = hybrid_map.local_map(node)
        if local_map is None:
            raise MapError(f"node {node} has no local map to navigate in")
        super().__init__(agent)
        self.agent = agent
        self.local_map = local_map
        self._square = is_square(hybrid_map)
        self._corner = str(hybrid_map.graph.nodes[node]["corner"])
        self._side = hybrid_map.meta.side
        self._landmarks = landmarks
        self.begin()
        self.listen(BehaviorFinished, self._on_finished)

    def begin(self) -> None:
        """The robot stands in the transition pose (again)."""
        self.pose = Pose()
        self.unit = self.local_map.nearest_unit(0.0, 0.0)
        self.stop()
        self._units: list[int] = []
        self._ahead: list[int] = []
        self._homeward = False
        self._belief = LocalPose(square=self._square, drift_rate=self.agent.odometry.drift_rate)
        if self._landmarks:
            walls = walls_at(self._side, self._corner, square=self._square, distance=WALL_DISTANCE)
            self._belief.know_corner(self._corner, walls if self._corner != "none" else ())

    def go(self, unit: int) -> None:
        """Sets out for a unit of the metric SOM, by A* over the edges not known to be blocked."""
        points = self._vantage_points() if self._belief.doubtful else {}
        here = (self._belief.x, self._belief.y)
        nearest = min(points, key=lambda unit: math.dist(points[unit], here), default=None)
        self._set_out([unit] if nearest is None else [nearest, unit], homeward=False)

    def home(self) -> None:
        """Sets out for the node itself, to end in the transition pose."""
        home = self.local_map.nearest_unit(0.0, 0.0)
        self._set_out([*(unit for unit in self._vantage_points() if unit != home), home], homeward=True)

    def _vantage_points(self) -> dict[int, tuple[float, float]]:
        """Places (m) from where walls of two directions can be seen, by unit; the nearest last."""
        found = {}
        for mark in self._belief.vantage_points() if self._landmarks else ():
            unit = self.local_map.nearest_unit(*mark.vantage)
            if math.dist(self.local_map.position(unit), mark.vantage) < VANTAGE_POINT:
                found[unit] = mark.vantage
        return found

    def _set_out(self, goals: list[int], *, homeward: bool) -> None:
        self.start()
        self._ahead, self._homeward = goals, homeward
        self._plan()

    def _plan(self) -> None:
        """Starts the drive to the next goal; a vantage point that cannot be reached is left out."""
        goal = self._ahead[0]
        try:
            path = self.local_map.path(self.unit, goal)
        except MapError as error:
            if len(self._ahead) > 1:
                self._ahead.pop(0)
                self._plan()
            else:
                self.finish(False, reason=str(error))
            return
        self._units = list(path)
        places = [self.local_map.position(unit) for unit in path]
        points = self._vantage_points()
        last = len(self._ahead) == 1
        home = last and self._homeward
        fix = not last or (home and goal in points)
        if home:
            places.append((0.0, 0.0))
        elif fix and goal in points:
            places.append(points[goal])
        start = (self.pose.x, self.pose.y, self.pose.heading)
        heading = 0.0 if home else None
        belief = self._belief.belief() if self._landmarks else None
        goal_of_drive = DrivePath(tuple(places), start, heading, belief, fix=fix and self._landmarks)
        self.agent.start("local-go-to", goal_of_drive)

    def _on_finished(self, event: BehaviorFinished) -> None:
        result = event.result
        if event.behavior != "local-go-to" or self.done or not isinstance(result, PlacesDriven):
            return
        self.pose = result.pose
        if result.belief is not None:
            self._belief = LocalPose.of(result.belief)
        reached = result.reached
        missed = reached >= len(self._units) and len(self._ahead) > 1
        if event.succeeded or missed:
            self.unit = self._units[-1] if self._units else self.unit
            self._ahead.pop(0)
            if self._ahead:
                self._plan()
            else:
                self.finish(True, self.unit, event.reason)
            return
        before = self._units[reached - 1] if reached else self.unit
        if reached < len(self._units) and self._units[reached] != before:
            self.unit = before
            self.local_map.block(before, self._units[reached])
            self._plan()
        else:
            self.finish(False, reason=event.reason)

    @property
    def reached(self) -> bool:
        """Whether the last trip ended at its goal."""
        return self.outcome is not None and self.outcome.succeeded


def is_square(hybrid_map: HybridMap) -> bool:
    """Whether the boundary turns by quarters at every corner, as far as it was measured."""
    quarter = 0.5 * math.pi
    turns = [float(data["turn"]) for _, data in hybrid_map.graph.nodes(data=True) if data["turn"]]
    squares = [(turn - quarter * round(turn / quarter)) ** 2 for turn in turns]
    return bool(squares) and math.sqrt(sum(squares) / len(squares)) <= ClosingConfig().square_limit
