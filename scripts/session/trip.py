"""A trip to a node of a map as a job of a session: where is the robot, and the drive."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...agent.events import Stuck
from ...agent.listener import Outcome
from ...agent.localization.localizer import Localizer
from ...agent.navigation.corners import Navigator
from ...agent.navigation.recovery import PATIENCE, TIME_PER_METER, RecoveringNavigator
from ...maps.sides import other_side
from ...maps.storage.map_file import MapFile
from ...world.robot import Pose, wrap_angle
from ..plain import report_values
from .assembly import make_navigator

if TYPE_CHECKING:
    from ...agent.goals import LegDriven
    from ...maps.hybrid_map import HybridMap
    from .stage import Stage

LOST_BEYOND = 0.15
"""Meters from the node it says it is at beyond which a robot is lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoReport:
    """How a trip went. position_error_m: true robot to true node, None where the node has no true place.

    localized_node, localized_after_m: for a robot that was not told where it was: where it found out, after
    driving how far along the boundary.
    """

    reached: bool
    lost: bool
    reason: str
    path: tuple[int, ...]
    legs: tuple[Mapping[str, Any], ...]
    position_error_m: float | None
    heading_error_deg: float | None
    distance_m: float
    collisions: int
    sim_time_s: float
    wall_time_s: float
    seed: int
    localized_node: int | None = None
    localized_after_m: float | None = None

    def to_json(self) -> dict[str, Any]:
        """The fields as a dict of JSON values."""
        return report_values(self)


class Trip:
    """A trip of one robot: `begin` it, ask `watch` once a tick until it is over, take the `report`.

    `drive` does all of that by itself. outcome: how it ended, None while it is under way; `result` is the
    node. guide: what drives it there, None until it is known where the robot is. localizer: what found that
    out last, or is at it.
    """

    def __init__(self, stage: Stage, hybrid_map: HybridMap, goal: int, robot: int = 0) -> None:
        """At the start; the clock of the computer runs from here."""
        self.stage, self.map, self.goal, self.robot = stage, hybrid_map, goal, robot
        self.agent = stage.robot(robot)
        stage.hybrid = hybrid_map
        self.outcome: Outcome | None = None
        self.guide: RecoveringNavigator | None = None
        self.localizer: Localizer | None = None
        self._began = time.perf_counter()
        self._arrival: str | None = None
        self._limit = math.inf
        self._stuck = False
        self._subscription = self.agent.bus.subscribe(Stuck, self._on_stuck)

    # --- driving -------------------------------------------------------------------------------------

    def drive(
        self, node: int | None, arrival: str | None, truth: Mapping[int, Pose], limit: float = math.inf
    ) -> GoReport:
        """Goes there and reports. limit: the simulated time (s) at which it is given up."""
        self.stage.places = truth
        self.begin(node, arrival)
        if self.outcome is None:
            self.run(limit)
        report = self.report(truth)
        self.close()
        return report

    def begin(self, node: int | None, arrival: str | None = None) -> None:
        """Sets out from a node that the robot came to by side `arrival`; None: it has to find out where."""
        self._arrival = arrival
        if node is not None:
            self._set_out(node)
            return
        self.localizer = Localizer(self.agent, self.map)
        self.localizer.start()
        self._limit = self.stage.time + PATIENCE + 3.0 * TIME_PER_METER * self.localizer.filter.loop_length

    def go_on(self, guide: RecoveringNavigator) -> None:
        """Sets out by a guide that has driven trips before, and keeps it."""
        self.guide = guide
        guide.go(self.goal)

    def run(self, limit: float = math.inf) -> None:
        """Lets the session run until it is over. limit: simulated s until it is given up."""
        if not self.stage.run(self.watch, limit=limit, doing=lambda: (None, self._doing())):
            reason = self.stage.trouble or "max time"
            self.cancel(reason)

    def watch(self) -> bool:
        """Goes on with the trip; whether it is over. Called once a tick."""
        guide, localizer = self.guide, self.localizer
        if self.outcome is not None:
            return True
        if guide is not None:
            self._look(guide)
        elif localizer is not None and (localizer.done or self._stuck or self.stage.time >= self._limit):
            if localizer.node is not None:
                self._set_out(localizer.node)
            else:
                self.outcome = Outcome(False, reason=localizer.reason or "found no place of the map in time")
        return self.outcome is not None

    def _set_out(self, node: int) -> None:
        navigator = make_navigator(self.stage.profile, self.agent, self.map, node, self._arrival)
        localizes = isinstance(navigator, Navigator)
        self.guide = guide = RecoveringNavigator(self.agent, self.map, navigator, localizes=localizes)
        guide.go(self.goal)
        self._look(guide)

    def _look(self, guide: RecoveringNavigator) -> None:
        self.localizer = guide.localizer or self.localizer
        if guide.done:
            self.outcome = Outcome(guide.reached, guide.navigator.node, guide.reason)

    def _doing(self) -> str:
        return "finding out where it is" if self.guide is None else f"on the way to node {self.goal}"

    @property
    def arrival(self) -> str | None:
        """The side along which the robot came to where it is, as far as it knows."""
        return None if self.guide is None else self.guide.navigator.arrival

    def cancel(self, reason: str = "cancelled") -> None:
        """Stops where the robot is; the next trip goes on from there."""
        if self.guide is not None:
            self.guide.stop(reason)
        elif self.localizer is not None:
            self.localizer.stop(reason)
        if self.outcome is None:
            self.outcome = Outcome(False, reason=reason)
        self._subscription.cancel()

    def close(self) -> None:
        """Hears no more; its guide, which nobody else has, neither."""
        self._subscription.cancel()
        if self.guide is not None:
            self.guide.close()

    def _on_stuck(self, event: Stuck) -> None:
        self._stuck |= event.given_up

    # --- scoring -------------------------------------------------------------------------------------

    def report(self, truth: Mapping[int, Pose]) -> GoReport:
        """Scores where the robot stands. truth: where nodes truly are (m, rad, world frame)."""
        outcome, guide, localizer = self.outcome or Outcome(False), self.guide, self.localizer
        error = turn = None
        if guide is not None and self.goal in truth:
            pose, place = self.stage.world.true_pose(self.robot), truth[self.goal]
            error = place.distance_to(pose)
            turn = math.degrees(abs(wrap_angle(pose.heading - place.heading)))
        legs = () if guide is None else tuple(_leg_values(leg) for leg in guide.legs)
        found = None if localizer is None else localizer.node
        return GoReport(
            reached=outcome.succeeded,
            lost=not outcome.succeeded or (error is not None and error > LOST_BEYOND),
            reason=self._reason(outcome),
            path=() if guide is None else tuple(guide.path),
            legs=legs,
            position_error_m=error,
            heading_error_deg=turn,
            distance_m=sum(float(str(leg["distance_m"])) for leg in legs),
            collisions=self.stage.world.collisions(self.robot),
            sim_time_s=self.stage.time,
            wall_time_s=time.perf_counter() - self._began,
            seed=self.stage.settings.seed,
            localized_node=found,
            localized_after_m=None if localizer is None or found is None else localizer.length,
        )

    def _reason(self, outcome: Outcome) -> str:
        """Why it ended; of a trip that tried several ways why each of them did."""
        guide = self.guide
        if guide is None or outcome.succeeded or outcome.reason != guide.reason:
            return outcome.reason
        return "; ".join(guide.reasons) or guide.reason

    def learn(self, path: Path) -> None:
        """Lets the map file learn from the trip: arcs driven to recognized ends, arcs found blocked."""
        if self.guide is None:
            return
        with MapFile.resume(path) as file:
            known, changed = file.map.graph, set()
            for leg in self.guide.legs:
                if leg.recognized and known.has_edge(leg.source, leg.target, leg.kind):
                    foray = leg.kind == "foray"
                    file.map.record_traversal(
                        leg.source, leg.target, leg.kind, leg.distance, both_ways=not foray
                    )
                    changed.add((leg.source, leg.target, leg.kind))
                    if not foray:
                        changed.add((leg.target, leg.source, other_side(leg.kind)))
            for key in self.guide.blocked:
                file.map.block(*key)
                changed.add(key)
            file.update(file.map, arcs=sorted(key for key in changed if known.has_edge(*key)))


def _leg_values(leg: LegDriven) -> dict[str, object]:
    return {
        "from": leg.source,
        "to": leg.target,
        "side": leg.side,
        "kind": leg.kind,
        "distance_m": leg.distance,
        "recognized": leg.recognized,
    }
