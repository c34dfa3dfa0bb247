"""Navigation as published (section 3.5): arcs by side and straight-line distance, corrected by views.

    turn around if the other side is to be followed -> follow the wall until the straight-line distance is
    as long as the arc -> (look around, take the best unit's place for one's own, drive to the middle) -> ...

What the thesis leaves open is settled in decision record 061.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import Percept, Pose
from ..events import BehaviorFinished
from ..goals import DrivePath, Follow, Leg, LegDriven, LookAround, PlacesDriven
from .base import BaseNavigator

if TYPE_CHECKING:
    from ...maps.hybrid_map import Arc, HybridMap
    from ..agent import Agent
    from ..behavior import Context


class Driving(Enum):
    """What navigation is waiting for."""

    IDLE = "idle"
    TURN = "turn around"
    FOLLOW = "follow the wall"
    LOOK = "look around"
    CENTER = "drive to the middle"
    FACE = "take the transition pose"


@dataclass(frozen=True, slots=True)
class ThesisNavigationConfig:
    """Settings. correct: whether the position is corrected by views at each node.

    longest: meters of driving, as a multiple of the arc's length plus `spare` (m), after which an arc whose
    straight-line distance was not reached is given up.
    """

    correct: bool = True
    longest: float = 4.0
    spare: float = 0.5


@dataclass(frozen=True, slots=True)
class Correction:
    """One correction: at `node`, `place` (m, local frame) is where the views say the robot was."""

    node: int
    place: tuple[float, float]
    distance: float


class ThesisNavigator(BaseNavigator):
    """Takes the robot from node to node of a map by the published method.

    on_arrival, on_corrected: called when an arc's distance is over, and when the position was corrected there
    and the robot holds to be in the transition pose.
    """

    behaviors = ("reactive-wall-following", "look-around", "local-go-to")

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        node: int,
        arrival: str | None = None,
        config: ThesisNavigationConfig = ThesisNavigationConfig(),
    ) -> None:
        """arrival: as in the base."""
        super().__init__(agent, hybrid_map, node, arrival)
        self.config = config
        self.corrections: list[Correction] = []
        self.on_arrival: Callable[[int], None] = lambda node: None
        self.on_corrected: Callable[[Correction], None] = lambda correction: None
        self._phase = Driving.IDLE
        self._arcs: list[Arc] = []
        self._from = Pose()
        self._begun = 0.0
        self._face = True
        self.listen(BehaviorFinished, self._on_finished)

    def drive(self, arcs: Iterable[Arc], face: bool = True) -> None:
        """Sets out along these arcs. face: whether to end in the transition pose (else as it arrives)."""
        self._arcs, self._face = list(arcs), face
        self._set_out(tuple(Leg(arc.start, arc.end, arc.side, arc.distance, "none") for arc in self._arcs))
        self._next()

    # --- the arcs, one after the other ---------------------------------------------------------------

    def _next(self) -> None:
        if not self._arcs:
            self._take_pose()
        elif self._arcs[0].side != self.arrival:
            self._turn_around(Driving.TURN)
        else:
            self._follow()

    def _turn_around(self, phase: Driving) -> None:
        self._phase = phase
        self.agent.start("look-around", LookAround(math.pi, views=False))

    def _follow(self) -> None:
        arc = self._arcs[0]
        self._phase, self.arrival = Driving.FOLLOW, arc.side
        self._from, self._begun = self.agent.odometry.pose, self.agent.odometry.travelled
        self.agent.start("reactive-wall-following", Follow(arc.side))

    def update(self, percept: Percept, context: Context) -> None:
        """Watches the distance from where the arc began. Called by the agent once a tick."""
        if self._phase is not Driving.FOLLOW or self.done:
            return
        arc = self._arcs[0]
        if context.pose.distance_to(self._from) >= arc.distance:
            self._end_arc(arc)
        elif self.agent.odometry.travelled - self._begun > (
            self.config.longest * arc.distance + self.config.spare
        ):
            self.agent.stop("reactive-wall-following")
            self._lose(f"never {arc.distance:.2f} m away from node {arc.start} on the way to {arc.end}")

    def _end_arc(self, arc: Arc) -> None:
        self.agent.stop("reactive-wall-following")
        self._arcs.pop(0)
        length = self.agent.odometry.travelled - self._begun
        self._passed(LegDriven(arc.start, arc.end, arc.side, length, False))
        self.on_arrival(arc.end)
        local_map = self.map.local_map(arc.end)
        if self.config.correct and local_map is not None and local_map.perceptual is not None:
            self._phase = Driving.LOOK
            turn = 0.0 if self.arrival == self.map.meta.side else math.pi
            self.arrival = self.map.meta.side
            self.agent.start("look-around", LookAround(turn))
        else:
            self._next()

    def _correct(self, panorama: Any) -> None:
        """Eq. 3.34 and 3.35: takes the best unit's place for the robot's own and drives to the middle."""
        local_map = self.map.local_map(self.node)
        assert local_map is not None
        estimate = local_map.locate(panorama, "best")
        x, y = (float(value) for value in estimate.position)
        self.corrections.append(Correction(self.node, (x, y), estimate.distance))
        self._phase = Driving.CENTER
        self.agent.start("local-go-to", DrivePath(((0.0, 0.0),), (x, y, 0.0), 0.0))

    def _take_pose(self) -> None:
        if self._face and self.arrival != self.map.meta.side:
            self.arrival = self.map.meta.side
            self._turn_around(Driving.FACE)
        else:
            self._arrive("arrived")

    def _on_finished(self, event: BehaviorFinished) -> None:
        phase = Driving.IDLE if self.done else self._phase
        if event.behavior == "look-around":
            if phase is Driving.TURN:
                self._follow()
            elif phase is Driving.LOOK:
                self._correct(event.result)
            elif phase is Driving.FACE:
                self._arrive("arrived")
        elif event.behavior == "local-go-to" and phase is Driving.CENTER:
            if event.succeeded or not isinstance(event.result, PlacesDriven):
                self.on_corrected(self.corrections[-1])
                self._next()
            else:
                # An obstacle bars the way to the middle: it turns to the entry heading where it stands.
                pose = event.result.pose
                self.agent.start("local-go-to", DrivePath((), (pose.x, pose.y, pose.heading), 0.0))
