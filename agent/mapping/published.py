"""Mapping as published (section 3.4): nodes by algorithm 1, loop closing by eq. 3.33, faults included.

    follow the wall -> turned and moved enough -> look around -> known view? close the loop : new node and arc
    -> explore locally by path integration -> train the local map -> follow the wall ...

What the thesis leaves open is settled in decision record 060.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Any

from ...world.robot import Percept, Pose, wrap_angle
from ..events import BehaviorFinished, CornerReached, LoopClosed, NodeCreated
from ..goals import ExploreLocally, Follow, LookAround
from .base import BaseMapper, MapSink, NodeSettings

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ..agent import Agent
    from ..behavior import Context


class ThesisPhase(Enum):
    """What mapping is waiting for."""

    FOLLOW = "follow the wall"
    LOOK = "look around before a new node"
    EXPLORE = "explore around the node"


@dataclass(frozen=True, slots=True)
class ThesisMappingConfig(NodeSettings):
    """Settings of mapping as published, beside those of every mapper.

    angle (rad), distance (m): algorithm 1's thresholds (table 4.1). closing: the loop is closed where the
    view is nearer to node 0's perceptual SOM than so many times its mean training distance D_a (table 4.17);
    None: never. settle: rad within `window` ticks, so little must the heading change for a turn to be over;
    None: a node may be made in mid-turn.
    """

    angle: float = math.radians(45.0)
    distance: float = 0.05
    closing: float | None = 1.0
    settle: float | None = math.radians(4.0)
    window: int = 16


class ThesisMapper(BaseMapper):
    """Builds a `HybridMap` with an `Agent` that has the behaviors of profile `thesis`.

    ratios: by node, how far (in D_a) the view taken before its creation was from node 0's perceptual SOM.
    """

    behaviors = ("reactive-wall-following", "look-around", "local-exploration")
    kept = (*BaseMapper.kept, "_before", "_origin", "_travelled")
    _corner: CornerReached
    """Where algorithm 1 noticed a change last."""

    def __init__(
        self,
        agent: Agent,
        hybrid_map: HybridMap,
        sink: MapSink,
        config: ThesisMappingConfig = ThesisMappingConfig(),
    ) -> None:
        """Listens to the agent; `start` starts the drive."""
        super().__init__(agent, hybrid_map, sink, config)
        self.config = config
        self.phase = ThesisPhase.FOLLOW
        self.ratios: dict[int, float] = {}
        self._before: Pose | None = None
        self._origin = 0.0
        self._travelled = 0.0
        self._headings: deque[float] = deque(maxlen=config.window)
        self.listen(NodeCreated, self._on_created)
        self.listen(BehaviorFinished, self._on_finished)

    def start(self) -> None:
        """Follows the wall from where the robot stands."""
        super().start()
        self._drive_on()

    def _drive_on(self) -> None:
        self.phase = ThesisPhase.FOLLOW
        self._headings.clear()
        self.agent.start("reactive-wall-following", Follow(self.config.side))

    # --- state ---------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly; to be taken while a node is committed."""
        return {**super().state(), "ratios": sorted(self.ratios.items())}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        super().restore(state)
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
        travelled = self.agent.odometry.travelled
        corner = CornerReached(
            time=context.time,
            side=self.config.side,
            kind="none",
            path_length=travelled - self._travelled,
            heading=context.pose.heading,
            turn=0.0,
        )
        self.agent.bus.publish(corner)
        self._corner = replace(corner, number=self.agent.bus.corners)
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
        if self.done:
            return
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
        previous = self._create(self._corner, corner="none", entry_heading=heading)
        if previous >= 0:
            self._join_straight(previous, self.current, pose)
        self._before = pose

    def _join_straight(self, source: int, target: int, pose: Pose) -> None:
        """Eq. 3.18: the arc's length is the straight line between the two estimates."""
        assert self._before is not None
        self._join(source, target, pose.distance_to(self._before))

    def _explore(self) -> None:
        self.phase = ThesisPhase.EXPLORE
        self.agent.start("local-exploration", ExploreLocally(self._strategy))

    def _on_created(self, event: NodeCreated) -> None:
        """Without local maps a node is complete at once, and the robot drives on without a stop."""
        if not self.config.local_maps and not self.done:
            self._commit()

    def _go_on(self) -> None:
        if self.phase is not ThesisPhase.FOLLOW:
            self._drive_on()

    def _close(self, first: int, pose: Pose) -> None:
        self._join_straight(self.current, first, pose)
        self.current = first
        time = self.agent.context.time
        self.agent.bus.publish(LoopClosed(time=time, node=first, met=self._corner.number))
        self._end(True, "loop closed")
