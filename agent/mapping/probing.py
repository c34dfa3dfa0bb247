"""Driving a wall twice, to tell what is its own bending and what the wheels make of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...maps.sides import other_side
from ...world.robot import wrap_angle
from ..estimation.wheel_calibration import SETTLED
from ..events import BehaviorFinished
from ..goals import FollowFrom, GoAlong, Leg
from ..listener import Listener

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..agent import Agent
    from ..estimation.wall_segments import WallSegmentMeter
    from ..events import CornerReached
    from ..listener import Outcome

LEAST_PROBE = 0.25
"""Meters of a wall from which on it is worth driving twice."""
_MOST = 0.6
"""Meters of a wall that are driven twice, at most."""


class WallProbe(Listener):
    """Drives back along the wall just followed and here again, by `go-to-node`; its result, the bend there.

    On the way back the wall's bending is undone, and what the wheels do is doubled: the meter learns from it.
    """

    def __init__(
        self, agent: Agent, side: str, meter: WallSegmentMeter, on_end: Callable[[Outcome], None]
    ) -> None:
        """side: of the wall."""
        super().__init__(agent, on_end)
        self.agent, self.side, self.meter = agent, side, meter
        self._bend: CornerReached | None = None
        self.listen(BehaviorFinished, self._on_finished)

    def probe(self, bend: CornerReached) -> None:
        """Sets out from a bend, where the robot stands beside the wall."""
        self._bend = bend
        self.start()
        length = self._length(bend)
        there = Leg(-1, -1, other_side(self.side), length, "none", math.pi, FollowFrom.WALL)
        back = Leg(-1, -1, self.side, length, "none", math.pi, FollowFrom.WALL)
        self.agent.start("go-to-node", GoAlong((there, back)))

    @staticmethod
    def _length(bend: CornerReached) -> float:
        return min(bend.path_length - SETTLED, _MOST)

    def _on_finished(self, event: BehaviorFinished) -> None:
        bend = self._bend
        if event.behavior != "go-to-node" or bend is None or self.done:
            return
        self._bend = None
        if event.succeeded:
            turned = wrap_angle(self.agent.odometry.heading - bend.heading)
            self.meter.calibrate(turned, 2.0 * self._length(bend), bend.path_length)
        self.finish(event.succeeded, bend, event.reason)
