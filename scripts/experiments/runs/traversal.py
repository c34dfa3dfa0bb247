"""One traversal run of an experiment: a map driven from its first node to its last and back, five times.

The robot is put at the first node as the map's own run met it. Each traversal goes once round where the loop
was closed, else to the last node; every second one goes back. The position error at a node is the true
distance between the robot and the true place of the node it says it is at; it is lost where that is more than
15 cm, or where it gives up (docs/experiments.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from ....agent.events import NodePassed
from ....agent.goals import ReacquireCorner
from ....agent.navigation.corners import Navigator
from ....agent.navigation.local import LocalNavigator
from ....agent.navigation.published import Correction, ThesisNavigator
from ....maps.hybrid_map import Arc, HybridMap
from ....world.errors import SimulationError
from ....world.robot import Pose, wrap_angle
from ...session.assembly import make_navigator
from ...session.profiles import find_profile
from ...session.simulation import Simulation
from ..worlds.named import experiment_world
from .over_map import LOST_BEYOND, mapped_for, read_map, simulated_as

TRAVERSALS = 5
LOCAL_IN = (1, 2, 4, 5)
"""Traversals in which every other local map is driven too (section 4.3.2)."""
_TIME_PER_METER, _TIME_AT_NODE = 150.0, 900.0


def run_traversal(settings: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Runs the traversals of a job; lengths in m, angles in rad."""
    hybrid_map, truth = read_map(mapped_for(settings, folder))
    arcs, corrected = round_of(hybrid_map), bool(settings["corrected"])
    first = arcs[0].start if arcs else hybrid_map.nodes()[0]
    world, run_as = experiment_world(str(settings["map world"]), folder), simulated_as(settings)
    profile = replace(find_profile(run_as.profile), correct=corrected)
    with Simulation(world, run_as, start=truth[first], profile=profile) as simulation:
        run = TraversalRun(simulation, hybrid_map, truth, first, corrected=corrected)
        try:
            run.drive()
        except SimulationError as error:  # counts as lost; the others go on
            run.lost = run.lost or str(error)
        return run.result()


@dataclass(slots=True)
class Scores:
    """What was measured. before, after, headings: at each node; ends: of the traversals.

    corrections: node, where it truly was (x, y) and where it held itself to be (x, y), m, the node's true
    frame: by the views at arrival (profile `thesis`), by the walls after driving the local map (`default`).
    """

    before: list[float] = field(default_factory=list)
    after: list[float] = field(default_factory=list)
    headings: list[float] = field(default_factory=list)
    ends: list[float] = field(default_factory=list)
    corrections: list[list[float]] = field(default_factory=list)
    local_units: int = 0
    local_reached: int = 0


class TraversalRun:
    """Five traversals of one map by one robot. Knows the truth; the agent does not."""

    def __init__(
        self,
        simulation: Simulation,
        hybrid_map: HybridMap,
        truth: Mapping[int, Pose],
        first: int,
        *,
        corrected: bool,
    ) -> None:
        """Makes the navigator of a robot that stands at node `first`."""
        self.simulation, self.map, self.truth, self.corrected = simulation, hybrid_map, truth, corrected
        self.world, self.agent, profile = simulation.world, simulation.agent, simulation.profile
        self.navigator = make_navigator(profile, self.agent, hybrid_map, first, None)
        self._comes_back = bool(profile.mapping.get("come_back", True))
        exploring = profile.behaviors.get("local-exploration", {})
        self._landmarks = profile.navigator == "corners" and bool(exploring.get("landmarks", True))
        self.scores = Scores()
        self.lost = ""
        self._local: LocalNavigator | None = None
        self._arrived_at = Pose()
        self.agent.bus.subscribe(NodePassed, self._on_passed)
        if isinstance(self.navigator, ThesisNavigator):
            self.navigator.on_corrected = self._on_corrected

    def drive(self) -> None:
        """All traversals, or as many as it takes to get lost (uncorrected: to give up)."""
        forward = round_of(self.map)
        for number in range(1, TRAVERSALS + 1):
            arcs = forward if number % 2 else [self._back(arc) for arc in reversed(forward)]
            local = self.corrected and number in LOCAL_IN
            done = self._node_by_node(arcs, local) if self.corrected else self._through(arcs)
            if not done:
                return
            self.scores.ends.append(self._error(self.navigator.node))

    def _back(self, arc: Arc) -> Arc:
        return self.map.arc(arc.end, arc.start, "left" if arc.kind == "right" else "right")

    # --- driving -------------------------------------------------------------------------------------

    def _through(self, arcs: Sequence[Arc]) -> bool:
        navigator = self.navigator
        if isinstance(navigator, ThesisNavigator):
            navigator.drive(arcs, face=False)
        elif isinstance(navigator, Navigator):
            navigator.drive(arcs)
        length = sum(arc.distance for arc in arcs)
        return self._run(_TIME_PER_METER * length + _TIME_AT_NODE)

    def _node_by_node(self, arcs: Sequence[Arc], local: bool) -> bool:
        for index, arc in enumerate(arcs):
            if not self._through([arc]):
                return False
            if not isinstance(self.navigator, ThesisNavigator):
                self._note_after(arc.end)
            if self.lost:
                return False
            if local and index % 2 == 0:
                self._drive_local(arc.end)
        return True

    def _until(self, done: Callable[[], bool], seconds: float) -> bool:
        """Ticks until it is done, or for so many simulated seconds; whether it is done."""
        return done() or self.simulation.run(done, limit=self.simulation.time + seconds)

    def _run(self, limit: float) -> bool:
        """Ticks until the navigator is done; False if it gave up."""
        navigator = self.navigator
        if not self._until(lambda: navigator.done, limit):
            self.lost = self.lost or self.simulation.trouble or f"not there after {limit:.0f} s"
            return False
        if not navigator.reached:
            self.lost = self.lost or navigator.reason
        return navigator.reached

    def _drive_local(self, node: int) -> None:
        """Visits every unit of the local map that was hit, and comes back."""
        local_map = self.map.local_map(node)
        if local_map is None:
            return
        if self._local is None or self._local.local_map is not local_map:
            self._local = LocalNavigator(self.agent, self.map, node, landmarks=self._landmarks)
        local = self._local
        local.begin()
        to_visit = [unit for unit in range(local_map.metric.units) if local_map.hits[unit] > 0]
        while to_visit:
            here = local_map.position(local.unit)
            unit = min(to_visit, key=lambda unit: math.dist(local_map.position(unit), here))
            to_visit.remove(unit)
            self.scores.local_units += 1
            local.go(unit)
            self._run_local(local)
            self.scores.local_reached += local.reached
        local.home()
        self._run_local(local)
        if isinstance(self.navigator, Navigator):
            true = self.truth[node].relative(self.world.true_pose())
            self.scores.corrections.append([float(node), true.x, true.y, local.pose.x, local.pose.y])
            if self._comes_back:
                self._come_to_corner(node)

    def _come_to_corner(self, node: int) -> None:
        """Corrects what driving the local map left, as profile `default` does after exploring one."""
        corner, side = self.map.graph.nodes[node]["corner"], self.map.meta.side
        room = [arc.distance for arc in self.map.leaving(node) if arc.kind not in (side, "foray")]
        if corner == "none" or not room:
            return
        self.agent.start("position-correction", ReacquireCorner(side, corner, room[0]))
        self._until(lambda: not self.agent.is_active("position-correction"), _TIME_AT_NODE)

    def _run_local(self, local: LocalNavigator) -> None:
        self._until(lambda: local.done, _TIME_AT_NODE)

    # --- scoring -------------------------------------------------------------------------------------

    def _error(self, node: int) -> float:
        return self.world.true_pose().distance_to(self.truth[node])

    def _on_passed(self, event: NodePassed) -> None:
        error = self._error(event.node)
        self.scores.before.append(error)
        self._arrived_at = self.truth[event.node].relative(self.world.true_pose())
        if error > LOST_BEYOND and not self.lost:
            self.lost = f"{100 * error:.0f} cm from node {event.node}, where it says it is"

    def _on_corrected(self, correction: Correction) -> None:
        self._note_after(correction.node)
        here = self._arrived_at
        self.scores.corrections.append([float(correction.node), here.x, here.y, *correction.place])

    def _note_after(self, node: int) -> None:
        pose, place = self.world.true_pose(), self.truth[node]
        self.scores.after.append(pose.distance_to(place))
        self.scores.headings.append(abs(wrap_angle(pose.heading - place.heading)))
        if self.scores.after[-1] > LOST_BEYOND and not self.lost:
            self.lost = f"{100 * self.scores.after[-1]:.0f} cm from node {node} after its correction"

    def result(self) -> dict[str, Any]:
        """All that was measured, as JSON values."""
        scores = self.scores
        complete = len(scores.ends) == TRAVERSALS
        return {
            "completed": complete and not self.lost,
            "driven": complete,
            "lost": self.lost,
            "end_error_m": scores.ends[-1] if complete else self._error(self.navigator.node),
            **asdict(scores),
            "corrections": scores.corrections[:200],
            "slope_m": _slope(scores.ends),
            "local_share": scores.local_reached / scores.local_units if scores.local_units else None,
            "collisions": self.world.collisions(),
            "sim_time_s": self.world.time,
        }


def round_of(hybrid_map: HybridMap) -> list[Arc]:
    """The arcs once round the loop, in the order of mapping; where none was closed, to the last node.

    A loop closed at another node than the first leaves out what was driven before.
    """
    side = hybrid_map.meta.side
    arcs: list[Arc] = []
    at = {hybrid_map.nodes()[0]: 0}
    arc = hybrid_map.next_arc(hybrid_map.nodes()[0], side)
    while arc is not None:
        arcs.append(arc)
        if arc.end in at:
            return arcs[at[arc.end] :]
        at[arc.end] = len(arcs)
        arc = hybrid_map.next_arc(arc.end, side)
    return arcs


def _slope(ends: Sequence[float]) -> float | None:
    """Least-squares growth (m a traversal) of the error at the ends of traversals."""
    if len(ends) < TRAVERSALS:
        return None
    middle = 0.5 * (len(ends) - 1)
    mean = math.fsum(ends) / len(ends)
    moments = math.fsum((k - middle) * (end - mean) for k, end in enumerate(ends))
    return moments / math.fsum((k - middle) ** 2 for k in range(len(ends)))
