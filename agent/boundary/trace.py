"""The boundary as the wall follower met it: corners and lengths, and when they make a closed loop.

A trace is a chain: corner 0, the way to corner 1, corner 1, ... Its frame has corner 0 at the origin and x
along the wall by which corner 0 was reached. Turns are the walls' own (from tangent to tangent), so the error
of path integration does not add up along walls; where every turn is close to a quarter, quarters are taken.
A wall that is not straight keeps the shape that path integration gave it: a `WallSegment`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ...world.robot import Pose

_QUARTER = 0.5 * math.pi
_SWING_SHARE = 0.5
"""How badly the turn of a bent wall is known, beside that of a corner that is no quarter."""


BEND = "bend"
"""Kind of a node on a wall that bends without a corner."""
_BEND_REACH = 0.4
"""How far, as a share of the arc there, a bend may be met elsewhere the next time."""
_ENOUGH = 3
"""Corners of a loop beside which its bends count for nothing."""
BLUNT = math.radians(84.0)
"""Turn (rad) at a corner up to which, when driving, it may be met one time and felt as a bend the next."""
WEAK = math.radians(40.0)
"""Turn (rad) of a corner up to which it may be taken for a bend of the wall another time."""


@dataclass(frozen=True, slots=True)
class WallSegment:
    """How a wall leads from corner to corner where it is not straight.

    dx, dy: m, from the one to the other, along and left of the wall's direction where it begins.
    dtheta: rad, counter-clockwise, from its direction where it begins to that where it ends.
    """

    dx: float
    dy: float
    dtheta: float


@dataclass(slots=True)
class Corner:
    """One corner of the trace.

    kind: "concave", "convex" or "bend". length: m from the corner before (0 for the first), as driven. turn:
    rad, counter-clockwise, from the wall before to the wall after; None until the wall after is known.
    way: from the corner before, None if straight.
    """

    kind: str
    length: float
    turn: float | None = None
    way: WallSegment | None = None

    @property
    def step(self) -> WallSegment:
        """The way from the corner before, straight or not."""
        return self.way or WallSegment(self.length, 0.0, 0.0)


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

    def reach(self, kind: str, length: float, way: WallSegment | None = None) -> int:
        """Adds a corner, `length` m after the last, and returns its index. way: None if straight."""
        first = not self.corners
        self.corners.append(Corner(kind, 0.0 if first else length, None, None if first else way))
        return len(self.corners) - 1

    def turned(self, turn: float) -> None:
        """Tells how the boundary turned at the last corner (rad); not before the next wall was followed."""
        if self.corners:
            self.corners[-1].turn = turn

    @property
    def is_right_angled(self) -> bool:
        """Whether all turns known so far are quarters, but for what measuring them costs."""
        turns = [corner.turn for corner in self.corners if corner.turn is not None]
        turns += [corner.way.dtheta for corner in self.corners if corner.way is not None]
        squares = [(turn - _QUARTER * round(turn / _QUARTER)) ** 2 for turn in turns]
        return bool(squares) and math.sqrt(sum(squares) / len(squares)) <= self.config.square_limit

    def poses(self) -> list[Pose]:
        """Each corner's place and the unwrapped heading of the wall by which it was reached."""
        square = self.is_right_angled
        poses: list[Pose] = []
        x = y = heading = 0.0
        for corner in self.corners:
            step = corner.step
            x += step.dx * math.cos(heading) - step.dy * math.sin(heading)
            y += step.dx * math.sin(heading) + step.dy * math.cos(heading)
            heading += 0.0 if square else step.dtheta
            poses.append(Pose(x, y, heading))
            turn = corner.turn or 0.0
            heading += _QUARTER * round(turn / _QUARTER) if square else turn
        return poses

    def candidate(self, bends: bool = True) -> int | None:
        """The earlier corner that the last one may be, nearest first in place; None if there is none.

        It must be of the same kind, the boundary have made one full turn since, and the place agree. Bends
        count only where there are too few corners: they come where the wall happens to have turned enough.
        bends: False if they do not count at all.
        """
        last = len(self.corners) - 1
        if last < 3:
            return None
        config, poses = self.config, self.poses()
        here = poses[last]
        square = self.is_right_angled
        best: tuple[float, int] | None = None
        length = 0.0
        corners = 0
        for index in range(last - 1, -1, -1):
            length += self.corners[index + 1].length
            corner = self.corners[index]
            corners += corner.kind != BEND
            if corner.kind != self.corners[last].kind or last - index < 3:
                continue
            if corner.kind == BEND and (corners >= _ENOUGH or not bends):
                continue
            net = abs(here.heading - poses[index].heading)
            slack = config.turn_gate + (0.0 if square else config.turn_deviation * math.sqrt(last - index))
            if abs(net - math.tau) > slack:
                continue
            gate = config.gate + config.gate_slope * length
            if not square:
                gate += 0.3 * config.turn_deviation * math.sqrt(last - index) * 0.5
            past, beside = self._apart(index)
            if corner.kind == BEND:
                past = max(0.0, abs(past) - self._reach_of(index))
            distance = math.hypot(past, beside)
            if distance <= gate and (best is None or distance < best[0]):
                best = (distance, index)
        return None if best is None else best[1]

    def past(self, index: int) -> float:
        """How far (m) the last corner, if it is a bend, lies beyond bend `index` that it was taken for."""
        if self.corners[index].kind != BEND:
            return 0.0
        reach = self._reach_of(index)
        return max(-reach, min(reach, self._apart(index)[0]))

    def _reach_of(self, index: int) -> float:
        """How far (m) from bend `index` it may be met another time."""
        return _BEND_REACH * self.corners[index + 1].length

    def _apart(self, index: int) -> tuple[float, float]:
        """How far (m) the last corner is from `index`, along and left of the way at `index`."""
        if self.is_right_angled or self.corners[index].kind == BEND:
            # A bend is met wherever the wall has turned enough: not after one full turn exactly.
            poses = self.poses()
            apart = poses[index].relative(poses[-1])
            return apart.x, apart.y
        return self._gap(index)

    def _gap(self, index: int) -> tuple[float, float]:
        """As `_apart`, if both are one corner, so that all turns make a full one.

        What the measured turns lack is shared among them, mostly by those that are no quarters: those are
        the ones that are hard to measure.
        """
        turns = [corner.turn or 0.0 for corner in self.corners[index:-1]]
        steps = [corner.step for corner in self.corners[index + 1 :]]
        shares = [1.0 if abs(turn - _QUARTER * round(turn / _QUARTER)) > 0.1 else 0.1 for turn in turns]
        total = sum(turns) + sum(step.dtheta for step in steps)
        weights = sum(shares) + sum(_SWING_SHARE for step in steps if step.dtheta)
        lack = (math.copysign(math.tau, total) - total) / weights
        x = y = heading = 0.0
        for turn, share, step in zip(turns, shares, steps, strict=True):
            swung = _SWING_SHARE * lack if step.dtheta else 0.0
            heading += turn + lack * share
            middle = heading + 0.5 * swung
            x += step.dx * math.cos(middle) - step.dy * math.sin(middle)
            y += step.dx * math.sin(middle) + step.dy * math.cos(middle)
            heading += step.dtheta + swung
        return x, y

    def _length_slack(self, index: int) -> float:
        corner = self.corners[index]
        slack = max(self.config.length_gate, self.config.length_slope * corner.length)
        return slack if corner.kind != BEND else slack + _BEND_REACH * corner.length

    def onward(self, index: int, kind: str, length: float) -> int | None:
        """The corner of this kind `length` m after corner `index`, or None.

        Bends and corners that hardly turn may be missed between the two: they are not met every time.
        """
        way = 0.0
        for further in range(index + 1, len(self.corners)):
            way += self.corners[further].length
            slack = max(self._length_slack(further), self.config.length_slope * way)
            if self.corners[further].kind == kind and abs(way - length) <= slack:
                return further
            if way > length + slack or not self.is_weak(further):
                return None
        return None

    def is_weak(self, index: int) -> bool:
        """Whether a corner may be met one time and not the next: it bends the boundary too little."""
        corner = self.corners[index]
        return corner.kind == BEND or (corner.turn is not None and abs(corner.turn) < WEAK)
