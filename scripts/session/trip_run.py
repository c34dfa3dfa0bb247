"""The former way to run a trip, for experiments until they use `trip.Trip` on a `Simulation`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from ...agent import Agent
from ...agent.events import Stuck
from ...agent.goals import LegDriven
from ...agent.localization.localizer import Localizer
from ...agent.navigation.base import AnyNavigator
from ...agent.navigation.corners import Navigator
from ...agent.navigation.recovery import TIME_PER_METER, RecoveringNavigator
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import Truth
from ...world import World
from ...world.robot import Pose, wrap_angle
from .requests import Progress, RunSettings, SessionError
from .trip import GoReport

LOST_BEYOND = 0.15
"""Meters from the node it says it is at beyond which a robot is lost."""


class Trip:
    """One trip: finding out where it is, if it was not told, and driving."""

    def __init__(
        self, request: RunSettings, world: World, agent: Agent, progress: Callable[[Progress], None]
    ) -> None:
        """At the start; the clock of the computer runs from here."""
        self.request, self.world, self.agent, self.progress = request, world, agent, progress
        self._began = time.perf_counter()
        self._told = 0.0
        self._stuck = False
        agent.bus.subscribe(Stuck, self._on_stuck)
        self._localizer: Localizer | None = None
        self.blocked: list[tuple[int, int, str]] = []
        self.attempts = 0

    @property
    def localizer(self) -> Localizer:
        """What found out last where the robot is, or is at it. Raises: SessionError if nothing ever did."""
        if self._localizer is None:
            raise SessionError("this trip never had to find out where it is")
        return self._localizer

    def localize(self, hybrid_map: HybridMap) -> int | None:
        """Drives along the boundary until the robot knows where it is; None if it never does."""
        self._localizer = localizer = Localizer(self.agent, hybrid_map)
        localizer.start()
        limit = self.world.time + 120.0 + 3.0 * TIME_PER_METER * localizer.filter.loop_length
        self._run(lambda: localizer.done or self._stuck, limit, "finding out where it is")
        return localizer.node

    def give_up(self) -> GoReport:
        """The report of a robot that never knew where it was."""
        assert self._localizer is not None
        return self._report(
            reached=False,
            reason=self._localizer.reason or "found no place of the map in time",
            path=(),
            legs=(),
        )

    def drive(self, navigator: AnyNavigator, goal: int, truth: Truth) -> GoReport:
        """Drives to the goal, by other ways where one is shut, and scores where it stops."""
        guide = RecoveringNavigator(
            self.agent, navigator.map, navigator, localizes=isinstance(navigator, Navigator)
        )
        guide.go(goal)
        self._run(lambda: guide.done, math.inf, f"on the way to node {goal}")
        self._localizer = guide.localizer or self._localizer
        self.attempts, self.blocked = guide.attempts, guide.blocked
        pose = self.world.true_pose()
        place = Pose(*truth.nodes[goal]["pose"]) if goal in truth.nodes else None
        report = self._report(
            reached=guide.reached,
            reason=guide.reason if guide.reached else "; ".join(guide.reasons) or guide.reason,
            path=tuple(guide.path),
            legs=tuple(_leg_values(leg) for leg in guide.legs),
            error=None if place is None else place.distance_to(pose),
            turn=None if place is None else math.degrees(abs(wrap_angle(pose.heading - place.heading))),
        )
        guide.close()
        return report

    def _on_stuck(self, event: Stuck) -> None:
        self._stuck |= event.given_up

    def _run(
        self,
        done: Callable[[], bool],
        limit: float,
        message: str,
    ) -> None:
        """Ticks until it is done."""
        while not done() and self.world.time < limit:
            self.agent.tick()
            self.world.step()
            if self.world.time - self._told >= 1.0:
                self._told = self.world.time
                self.progress(Progress(self._told, 0, message))

    def _report(
        self,
        *,
        reached: bool,
        reason: str,
        path: tuple[int, ...],
        legs: tuple[dict[str, object], ...],
        error: float | None = None,
        turn: float | None = None,
    ) -> GoReport:
        localizer = self._localizer
        found = localizer is not None and localizer.node is not None
        return GoReport(
            reached=reached,
            lost=not reached or (error is not None and error > LOST_BEYOND),
            reason=reason,
            path=path,
            legs=legs,
            position_error_m=error,
            heading_error_deg=turn,
            distance_m=sum(float(str(leg["distance_m"])) for leg in legs),
            collisions=self.world.collisions(),
            sim_time_s=self.world.time,
            wall_time_s=time.perf_counter() - self._began,
            seed=self.request.seed,
            localized_node=localizer.node if localizer is not None else None,
            localized_after_m=localizer.length if localizer is not None and found else None,
        )


def _leg_values(leg: LegDriven) -> dict[str, object]:
    return {
        "from": leg.source,
        "to": leg.target,
        "side": leg.side,
        "kind": leg.kind,
        "distance_m": leg.distance,
        "recognized": leg.recognized,
    }
