"""The boundary as the wall follower met it: corners and lengths, and when they make a closed loop.

A trace is a chain: corner 0, length to corner 1, corner 1, ... Its frame has corner 0 at the origin and x
along the wall by which corner 0 was reached. Turns are the walls' own (from tangent to tangent), so the error
of path integration does not add up along walls; where every turn is close to a quarter, quarters are taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..world.robot import Pose, wrap_angle

_QUARTER = 0.5 * math.pi


@dataclass(slots=True)
class Corner:
    """One corner of the trace.

    kind: "concave" or "convex". length: m from the corner before (0 for the first). turn: rad,
    counter-clockwise, from the wall before to the wall after; None until the wall after is known.
    """

    kind: str
    length: float
    turn: float | None = None


@dataclass(frozen=True, slots=True)
class ClosingConfig:
    """When a corner may be one that was met before.

    gate: m, plus gate_slope x length of the loop. turn_gate: rad, how far the loop's net turn may be from a
    full one; it grows by turn_deviation x sqrt(corners) where turns are not quarters. confirmations: how many
    corners more must agree in kind and, within length_gate (m) or length_slope, in distance.
    square_limit: root mean square deviation (rad) from quarters up to which a room counts as right-angled.
    """

    gate: float = 0.04
    gate_slope: float = 0.01
    turn_gate: float = 0.35
    turn_deviation: float = 0.02
    confirmations: int = 2
    length_gate: float = 0.03
    length_slope: float = 0.05
    square_limit: float = 0.05


@dataclass(slots=True)
class BoundaryTrace:
    """Grows corner by corner while the robot maps, and says which earlier corner the last one may be."""

    config: ClosingConfig = field(default_factory=ClosingConfig)
    corners: list[Corner] = field(default_factory=list)

    def reach(self, kind: str, length: float) -> int:
        """Adds a corner, `length` m after the last, and returns its index."""
        self.corners.append(Corner(kind, length if self.corners else 0.0))
        return len(self.corners) - 1

    def turned(self, turn: float) -> None:
        """Tells how the boundary turned at the last corner (rad); not before the next wall was followed."""
        if self.corners:
            self.corners[-1].turn = turn

    @property
    def is_right_angled(self) -> bool:
        """Whether all turns known so far are quarters, but for what measuring them costs."""
        squares = [
            (turn - _QUARTER * round(turn / _QUARTER)) ** 2
            for turn in (corner.turn for corner in self.corners)
            if turn is not None
        ]
        return bool(squares) and math.sqrt(sum(squares) / len(squares)) <= self.config.square_limit

    def turn_at(self, index: int) -> float:
        """The turn (rad) at a corner: measured, or the quarter it stands for in a right-angled room."""
        turn = self.corners[index].turn
        if turn is None:
            return 0.0
        return _QUARTER * round(turn / _QUARTER) if self.is_right_angled else turn

    def poses(self) -> list[Pose]:
        """Each corner's place and the unwrapped heading of the wall by which it was reached."""
        square = self.is_right_angled
        poses: list[Pose] = []
        x = y = heading = 0.0
        for index, corner in enumerate(self.corners):
            if index:
                x += corner.length * math.cos(heading)
                y += corner.length * math.sin(heading)
            poses.append(Pose(x, y, heading))
            turn = corner.turn or 0.0
            heading += _QUARTER * round(turn / _QUARTER) if square else turn
        return poses

    def candidate(self) -> int | None:
        """The earlier corner that the last one may be, nearest first in place; None if there is none.

        It must be of the same kind, the boundary have made one full turn since, and the place agree.
        """
        last = len(self.corners) - 1
        if last < 3:
            return None
        config, poses = self.config, self.poses()
        here = poses[last]
        square = self.is_right_angled
        best: tuple[float, int] | None = None
        length = 0.0
        for index in range(last - 1, -1, -1):
            length += self.corners[index + 1].length
            if self.corners[index].kind != self.corners[last].kind or last - index < 3:
                continue
            net = abs(here.heading - poses[index].heading)
            slack = config.turn_gate + (0.0 if square else config.turn_deviation * math.sqrt(last - index))
            if abs(net - math.tau) > slack:
                continue
            gate = config.gate + config.gate_slope * length
            if not square:
                gate += 0.3 * config.turn_deviation * math.sqrt(last - index) * 0.5
            distance = here.distance_to(poses[index]) if square else self._gap(index)
            if distance <= gate and (best is None or distance < best[0]):
                best = (distance, index)
        return None if best is None else best[1]

    def _gap(self, index: int) -> float:
        """How far (m) the last corner is from `index` if they are one, so that all turns make a full one.

        What the measured turns lack is shared among them, mostly by those that are no quarters: those are
        the ones that are hard to measure.
        """
        turns = [corner.turn or 0.0 for corner in self.corners[index:-1]]
        shares = [1.0 if abs(turn - _QUARTER * round(turn / _QUARTER)) > 0.1 else 0.1 for turn in turns]
        lack = (math.copysign(math.tau, sum(turns)) - sum(turns)) / sum(shares)
        x = y = heading = 0.0
        for turn, share, corner in zip(turns, shares, self.corners[index + 1 :], strict=True):
            heading += turn + lack * share
            x += corner.length * math.cos(heading)
            y += corner.length * math.sin(heading)
        return math.hypot(x, y)

    def agrees(self, index: int, kind: str, length: float) -> bool:
        """Whether a corner of this kind, `length` m after the one before, can be corner `index`."""
        corner = self.corners[index]
        slack = max(self.config.length_gate, self.config.length_slope * corner.length)
        return corner.kind == kind and abs(corner.length - length) <= slack

    def closing_error(self, index: int) -> Pose:
        """How far the last corner's estimate is from corner `index`: m, m, rad (wrapped)."""
        poses = self.poses()
        here, there = poses[-1], poses[index]
        return Pose(here.x - there.x, here.y - there.y, wrap_angle(here.heading - there.heading))
