"""Mapping as published (section 3.4): nodes by algorithm 1, loop closing by eq. 3.33, faults included.

    follow the wall -> turned and moved enough -> look around -> known view? close the loop : new node and arc
    -> explore locally by path integration -> train the local map -> follow the wall ...

What the thesis leaves open is settled in decision record 060.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import Percept, Pose, wrap_angle
from ..events import (
    ArcAdded,
    BehaviorFinished,
    CornerReached,
    LocalMapBuilt,
    LoopClosed,
    NodeCommitted,
    NodeCreated,
)
from ..goals import ExploreLocally, Follow, LocalSamples, LookAround

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...maps.local.local_map import LocalMap
    from ..agent import Agent
    from ..behavior import Context

_STRATEGIES = {"rows": ("rows", "rows"), "columns": ("columns", "columns"), "alternate": ("rows", "columns")}


class ThesisPhase(Enum):
    """What mapping is waiting for."""

    FOLLOW = "follow the wall"
    LOOK = "look around before a new node"
    EXPLORE = "explore around the node"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class ThesisMappingConfig:
    """Settings of mapping as published.

    side: of the wall. local_maps: whether to explore around nodes. strategy: "rows", "columns" or
    "alternate". max_nodes: end after so many, None for no limit. angle (rad), distance (m): algorithm 1's
    thresholds (table 4.1). closing: the loop is closed where the view is nearer to node 0's perceptual SOM
    than so many times its mean training distance D_a (table 4.17); None: never. settle: rad within `window`
    ticks, so little must the heading change for a turn to be over; None: a node may be made in mid-turn.
    """

    side: str = "right"
    local_maps: bool = True
    strategy: str = "alternate"
    max_nodes: int | None = None
    angle: float = math.radians(45.0)
    distance: float = 0.05
    closing: float | None = 1.0
    settle: float | None = math.radians(4.0)
    window: int = 16


class ThesisMapper:
    """Builds a `HybridMap` with an `Agent` that has the behaviors of profile `thesis`.

    build, on_commit, `reason`: as in `mapping.Mapper`. ratios: by node, how far (in D_a) the view taken
    before its creation was from node 0's perceptual SOM.
    """

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        build: Callable[[LocalSamples, float], LocalMap],
        config: ThesisMappingConfig = ThesisMappingConfig(),
        on_commit: Callable[[int, float], None] = lambda node, met_at: None,
    ) -> None:
        """Subscribes to the agent; `begin` starts the drive, `drive_on` goes on after `restore`."""
        self.agent = agent
        self.map = hybrid_map
        self.config = config
        self.phase = ThesisPhase.FOLLOW
        self.reason = ""
        self.current = -1
        self.ratios: dict[int, float] = {}
        self._build = build
        self._on_commit = on_commit
        self._before: Pose | None = None
        self._origin = 0.0
        self._travelled = 0.0
        self._met_at = 0.0
        self._headings: deque[float] = deque(maxlen=config.window)
        agent.attach(self)
        agent.bus.subscribe(NodeCreated, self._on_created)
        agent.bus.subscribe(BehaviorFinished, self._on_finished)

    @property
    def done(self) -> bool:
        """Whether mapping has ended; `reason` says why."""
        return bool(self.reason)

    def begin(self) -> None:
        """Starts following the wall from wherever the robot stands."""
        self.drive_on()

    def drive_on(self) -> None:
        """Follows the wall from where the robot stands."""
        self.phase = ThesisPhase.FOLLOW
        self._headings.clear()
        self.agent.start("reactive-wall-following", Follow(self.config.side))

    def stop(self, reason: str) -> None:
        """Ends the mapping from outside."""
        self.reason = reason
        self.phase = ThesisPhase.DONE
        self.agent.stop("reactive-wall-following")

    # --- state ---------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly, as JSON; to be taken in `on_commit`."""
        before = self._before
        return {
            "current": self.current,
            "before": None if before is None else [before.x, before.y, before.heading],
            "origin": self._origin,
            "travelled": self._travelled,
            "ratios": sorted(self.ratios.items()),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`; `drive_on` then goes on from there."""
        self.current = int(state["current"])
        self._before = None if state["before"] is None else Pose(*state["before"])
        self._origin, self._travelled = float(state["origin"]), float(state["travelled"])
        self.ratios = {int(node): float(ratio) for node, ratio in state["ratios"]}

    # --- algorithm 1 ---------------------------------------------------------------------------------

    def update(self, percept: Percept, context: Context) -> None:
        """Audits path integration for a change in topography. Called by the agent once a tick."""
        if self.phase is not ThesisPhase.FOLLOW or self.done:
            return
        here, before = context.pose, self._before
        self._headings.append(here.heading)
        if before is None:
            self._before = here
            return
        turned = abs(wrap_angle(here.heading - before.heading))
        changed = turned > self.config.angle and here.distance_to(before) > self.config.distance
        if changed and self._settled(here.heading):
            self._change(context)

    def _settled(self, heading: float) -> bool:
        """Whether the robot has stopped turning."""
        limit = self.config.settle
        if limit is None:
            return True
        full = len(self._headings) == self.config.window
        return full and all(abs(wrap_angle(heading - past)) < limit for past in self._headings)

    def _change(self, context: Context) -> None:
        self._met_at = context.time
        travelled = self.agent.odometry.travelled
        self.agent.bus.publish(
            CornerReached(
                time=context.time,
                side=self.config.side,
                kind="none",
                path_length=travelled - self._travelled,
                heading=context.pose.heading,
                turn=0.0,
            )
        )
        self._travelled = travelled
        if not self.config.local_maps:
            self._add_node(context.pose)
            return
        self.agent.stop("reactive-wall-following")
        if self.current < 0:
            self._add_node(context.pose)
            self._explore()
        else:
            self.phase = ThesisPhase.LOOK
            self.agent.start("look-around", LookAround())

    def _on_finished(self, event: BehaviorFinished) -> None:
        if event.behavior == "look-around" and self.phase is ThesisPhase.LOOK:
            self._compare(event.result)
        elif event.behavior == "local-exploration" and self.phase is ThesisPhase.EXPLORE:
            self._keep_samples(event.result)
            self._commit()

    # --- steps ---------------------------------------------------------------------------------------

    def _compare(self, panorama: Any) -> None:
        """Eq. 3.33: is the view one of node 0's? Closes the loop, or adds the node and explores it."""
        first = self.map.nodes()[0]
        local_map = self.map.local_map(first)
        ratio = math.inf
        if local_map is not None and local_map.perceptual is not None:
            distance = local_map.locate(panorama).distance
            ratio = distance / local_map.view_error if local_map.view_error > 0.0 else math.inf
        pose = self.agent.odometry.pose
        if self.config.closing is not None and ratio < self.config.closing:
            self._close(first, pose)
            return
        self._add_node(pose)
        if math.isfinite(ratio):
            self.ratios[self.current] = ratio
        self._explore()

    def _add_node(self, pose: Pose) -> None:
        """Adds a node at a pose (path-integrated), and the arcs that join it to the one before."""
        if self.current < 0:
            self._origin = pose.heading
        heading = wrap_angle(pose.heading - self._origin)
        node = self.map.add_node(corner="none", entry_heading=heading)
        previous, self.current = self.current, node
        time = self.agent.context.time
        self.agent.bus.publish(NodeCreated(time=time, node=node, corner="none", met_at=self._met_at))
        if previous >= 0:
            self._add_arc(previous, node, pose)
        self._before = pose

    def _add_arc(self, source: int, target: int, pose: Pose) -> None:
        """Eq. 3.18: the arc's length is the straight line between the two estimates."""
        assert self._before is not None
        side, distance = self.config.side, pose.distance_to(self._before)
        self.map.add_arc(source, target, side=side, distance=distance)
        time = self.agent.context.time
        self.agent.bus.publish(
            ArcAdded(time=time, source=source, target=target, side=side, distance=distance)
        )

    def _explore(self) -> None:
        self.phase = ThesisPhase.EXPLORE
        strategy = _STRATEGIES[self.config.strategy][self.current % 2]
        self.agent.start("local-exploration", ExploreLocally(strategy))

    def _keep_samples(self, samples: Any) -> None:
        node = self.current
        if not isinstance(samples, LocalSamples) or len(samples.positions) == 0:
            return
        heading = self.map.graph.nodes[node]["entry_heading"]
        self.map.graph.nodes[node]["local_map"] = self._build(samples, heading)
        self.agent.bus.publish(
            LocalMapBuilt(
                time=self.agent.context.time,
                node=node,
                positions=len(samples.positions),
                panoramas=len(samples.panoramas),
            )
        )

    def _on_created(self, event: NodeCreated) -> None:
        """Without local maps a node is complete at once, and the robot drives on without a stop."""
        if not self.config.local_maps:
            self._commit()

    def _commit(self) -> None:
        """The node is complete: says so, and drives on."""
        self._on_commit(self.current, self._met_at)
        self.agent.bus.publish(NodeCommitted(time=self.agent.context.time, node=self.current))
        limit = self.config.max_nodes
        if limit is not None and self.map.graph.number_of_nodes() >= limit:
            self.stop("max nodes")
        elif self.phase is not ThesisPhase.FOLLOW:
            self.drive_on()

    def _close(self, first: int, pose: Pose) -> None:
        self._add_arc(self.current, first, pose)
        self.current = first
        self.agent.bus.publish(LoopClosed(time=self.agent.context.time, node=first, met_at=self._met_at))
        self.stop("loop closed")
