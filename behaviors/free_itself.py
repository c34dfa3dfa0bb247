"""Free itself: notices that the wheels turn and nothing moves, and works the robot loose."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum

from ..agent.behavior import Behavior, Context, Proposal, Transition
from ..agent.events import Freed, Stuck
from ..world.robot import LEFT_FRONT, LEFT_REAR, RIGHT_FRONT, RIGHT_REAR, STOP, Percept, WheelCommand


@dataclass(frozen=True, slots=True)
class FreeingConfig:
    """Settings. window: s looked back. way: m the wheels say were driven in it, straight, to be suspicious.

    turn: rad, the same for turning in place. near: m from the rim; only what is nearer tells. change: share
    by which an infrared value must change to count as moving. back: m to back up. speed: steps/s.
    attempts: until it gives up. rest: s without trouble after which the count starts again. tilt: deg.
    """

    window: float = 2.0
    way: float = 0.04
    turn: float = 1.5
    near: float = 0.04
    change: float = 0.25
    back: float = 0.03
    speed: float = 150.0
    attempts: int = 3
    rest: float = 10.0
    tilt: float = 30.0


class Freeing(Enum):
    """WATCHING: comparing wheels with sensors. BACKING, TURNING: working loose. GIVEN_UP: in vain."""

    WATCHING = "watching"
    BACKING = "backing"
    TURNING = "turning"
    GIVEN_UP = "given up"


_TILTED_TICKS = 15
"""A bump tilts the gravity that is felt too, but not for half a second."""


@dataclass(frozen=True, slots=True)
class _Moment:
    """One tick of the window: time (s), driven (m) and turned (rad) so far, infrared values."""

    time: float
    driven: float
    turned: float
    infrared: tuple[float, ...]


class FreeItself(Behavior):
    """Works a stuck robot loose: backs up, turns at random. Publishes `Stuck`, then `Freed` or gives up.

    It suspects that it is stuck when, within the window, the wheels drove straight and something near ahead
    (behind, when backing) stayed where it is, or the wheels turned and everything near stayed. Beside a long
    wall nothing ahead is near, so following one is not suspected. A robot tilted by `tilt` gives up at once.
    """

    name = "free-itself"
    priority = 60
    States = Freeing
    initial = Freeing.WATCHING
    Config = FreeingConfig
    restarts = True
    transitions = (
        Transition("stuck", Freeing.WATCHING, Freeing.BACKING),
        Transition("backed", Freeing.BACKING, Freeing.TURNING),
        Transition("tried", Freeing.TURNING, Freeing.WATCHING),
        Transition("give_up", Freeing.WATCHING, Freeing.GIVEN_UP),
    )
    config: FreeingConfig

    def on_reset(self) -> None:
        """Forgets the window and the attempts."""
        self._window: deque[_Moment] = deque()
        self._driven = self._turned = 0.0
        self._left = 0.0
        self._way = 1.0
        self._side = 1.0
        self._until = 0.0
        self._attempts = 0
        self._last_attempt = -math.inf
        self._tilted = 0

    def on_tick(self, percept: Percept, context: Context) -> None:
        """Counts what the wheels say was driven and turned."""
        self._driven += context.distance
        self._turned += context.turn

    def given_up(self, percept: Percept, context: Context) -> Proposal | None:
        """Has nothing to say any more."""
        return None

    def watching(self, percept: Percept, context: Context) -> Proposal | None:
        """Silent while what the wheels say and what is sensed fit together; else begins to work loose."""
        window, now = self._window, context.time
        self._tilted = self._tilted + 1 if self._is_tilted(percept) else 0
        if self._tilted >= _TILTED_TICKS:
            return self._give_up(context, "tipped over")
        window.append(_Moment(now, self._driven, self._turned, percept.infrared))
        if now - window[0].time < self.config.window:
            return None
        first = window.popleft()
        if self._attempts and now - self._last_attempt > self.config.rest:
            context.publish(Freed(time=now, attempts=self._attempts))
            self._attempts = 0
        reason = self._suspicion(first, window[-1], context)
        if reason is None:
            return None
        if self._attempts >= self.config.attempts:
            return self._give_up(context, f"{reason}; {self._attempts} attempts in vain")
        return self._begin(percept, context, reason, self._driven - first.driven)

    def _is_tilted(self, percept: Percept) -> bool:
        x, y, z = percept.accelerometer
        return bool(math.atan2(math.hypot(x, y), z) > math.radians(self.config.tilt))

    def _suspicion(self, first: _Moment, last: _Moment, context: Context) -> str | None:
        driven, turned = last.driven - first.driven, last.turned - first.turned
        if abs(driven) >= self.config.way and abs(turned) < 0.3:
            watched: tuple[int, ...] = (RIGHT_FRONT, LEFT_FRONT) if driven > 0.0 else (RIGHT_REAR, LEFT_REAR)
            what = f"the wheels drove {abs(driven) * 100:.0f} cm"
        elif abs(turned) >= self.config.turn and abs(driven) < self.config.way:
            watched = tuple(range(len(first.infrared)))
            what = f"the wheels turned {math.degrees(abs(turned)):.0f} deg"
        else:
            return None
        distance = context.geometry.infrared_distance
        near = [sensor for sensor in watched if distance(first.infrared[sensor]) < self.config.near]
        if not near or any(self._changed(sensor) for sensor in near):
            return None
        return f"{what}, what is near stays where it is"

    def _changed(self, sensor: int) -> bool:
        values = [moment.infrared[sensor] for moment in self._window]
        return max(values) - min(values) > self.config.change * max(values)

    def _begin(self, percept: Percept, context: Context, reason: str, driven: float) -> Proposal:
        context.publish(Stuck(time=context.time, reason=reason))
        self._attempts += 1
        self._last_attempt = context.time
        self._window.clear()
        self._left = self.config.back * self._attempts
        self._way = -1.0 if driven >= 0.0 else 1.0
        self._side = 1.0 if context.rng.random() < 0.5 else -1.0
        self._until = context.time + 4.0
        self.fire("stuck")
        return self.backing(percept, context)

    def backing(self, percept: Percept, context: Context) -> Proposal:
        """Backs up, away from where it was driving, farther with each attempt."""
        self._left -= abs(context.distance)
        if self._left <= 0.0 or context.time > self._until:
            self._left = float(context.rng.uniform(0.5, 1.5))
            self._until = context.time + 4.0
            self.fire("backed")
        speed = self._way * self.config.speed
        # Not quite straight: a shell that is wedged comes loose more easily in a curve.
        return Proposal(WheelCommand(speed, speed * 0.8), reason=f"stuck: attempt {self._attempts}")

    def turning(self, percept: Percept, context: Context) -> Proposal:
        """Turns in place by a random angle."""
        self._left -= abs(context.turn)
        if self._left <= 0.0 or context.time > self._until:
            self.fire("tried")
        speed = self._side * self.config.speed
        return Proposal(WheelCommand(-speed, speed), reason=f"stuck: attempt {self._attempts}")

    def _give_up(self, context: Context, reason: str) -> Proposal:
        context.publish(Stuck(time=context.time, reason=reason, given_up=True))
        self.fire("give_up")
        self.finish(False, reason)
        return Proposal(STOP, reason=reason)
