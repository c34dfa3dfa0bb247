"""What one behavior gets of the agent: a context of its own, and a way to the bus with limits.

Each behavior has its own context and random generator, so that none can change what another sees, and a
plugin that draws random numbers changes nobody else's.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..files.interrupts import ends_run
from ..world.robot import Image, Percept, RobotGeometry
from .behavior import Behavior, Context, Proposal
from .containment import LONGEST, Watchdog, check_plain, check_proposal, checked_event, describe
from .errors import EventFloodError, SubscriptionLeakError
from .events import Event, EventBus, Subscription
from .listener import Outcome


@dataclass(frozen=True, slots=True)
class Limits:
    """What a behavior may use up before it counts as faulty.

    events: published in one tick. subscriptions: held at once. budget: wall-clock seconds of one `propose`;
    None turns it off. hang: wall-clock seconds after which Python code is interrupted (main thread, POSIX
    only); None turns it off. wild: speeds beyond so many times the robot's maximum are a fault, not clamped.
    """

    events: int = 100
    subscriptions: int = 50
    budget: float | None = 0.5
    hang: float | None = None
    wild: float = 10.0


class BehaviorHandle:
    """The agent's side of one behavior. A broken limit is raised at once, and kept in `broken`."""

    __slots__ = (
        "_bus",
        "_events",
        "_limits",
        "_stop_watch",
        "_watch",
        "_wildest",
        "behavior",
        "broken",
        "context",
        "name",
        "outcome",
        "priority",
        "restarts",
    )

    def __init__(
        self,
        behavior: Behavior,
        bus: EventBus,
        limits: Limits,
        watch: Watchdog,
        geometry: RobotGeometry,
        look: Callable[[], Image],
        seed: np.random.SeedSequence,
    ) -> None:
        """seed: the agent's; the behavior's own is derived from it and the name."""
        cls = type(behavior)
        self.behavior = behavior  # what it declares is taken once: later it is only asked under watch
        self.name, self.priority, self.restarts = cls.name, cls.priority, bool(cls.restarts)
        self._stop_watch = nullcontext() if cls.slow_start else watch
        self._wildest = limits.wild * geometry.max_speed
        self.broken: Exception | None = None
        self.outcome: Outcome | None = None
        """How it ended, as it said when it was asked last; None while it has not."""
        self._bus, self._limits, self._watch, self._events = bus, limits, watch, 0
        self.context = Context(
            geometry=geometry,
            publish=self.publish,
            look=look,
            rng=np.random.default_rng(_own_seed(seed, self.name)),
            subscribe=self.subscribe,
        )

    def renew(self, source: Context, in_control: bool) -> Context:
        """The behavior's context with this tick's values; called once a tick before `propose`."""
        own = self.context
        own.time, own.pose, own.in_control = source.time, source.pose, in_control
        own.distance, own.turn = source.distance, source.turn
        self._events = 0
        return own

    # --- all that runs the behavior's own code; each may raise anything, `end` nothing -----------------

    def adopt(self, configs: Mapping[str, Any]) -> None:
        """Has it make the behaviors that it drives by."""
        with self._stop_watch:
            self.behavior.adopt(configs)

    def start(self, goal: Any) -> Any:
        """Starts it; returns the goal as it was fitted."""
        with self._stop_watch:
            self.behavior.start(goal, self.context)
            return self.behavior.goal

    def ask(self, percept: Percept, suspended: bool = False) -> Proposal | None:
        """What it proposes in this tick, checked; None too where it has finished: `outcome` says how.

        All is asked here, before the wheels are told anything. suspended: asks only whether it has finished.
        """
        behavior = self.behavior
        with self._watch:
            proposal = None
            if not (suspended or behavior.finished):
                proposal = behavior.propose(percept, self.context)
            if behavior.finished:
                self.outcome = self._ended()
        if self.broken is not None:
            raise self.broken
        if proposal is not None:
            check_proposal(proposal, self._wildest)
        return proposal

    def _ended(self) -> Outcome:
        behavior = self.behavior
        check_plain(behavior.result)
        return Outcome(bool(behavior.succeeded), behavior.result, str(behavior.reason)[:LONGEST])

    def end(self) -> str:
        """Stops it and ends its subscriptions; what went wrong, or nothing."""
        problem = ""
        try:
            with self._stop_watch:
                self.behavior.stop(self.context)
        except BaseException as fault:
            if ends_run(fault):
                raise
            problem = describe(fault)
        finally:
            self.release()
        return problem

    # --- what it may do --------------------------------------------------------------------------------

    def publish(self, event: Event) -> bool:
        """Queues an event. Raises: EventFloodError beyond the limit, TypeError for what is no event."""
        event = checked_event(event)
        self._events += 1
        if self._events > self._limits.events:
            self.broken = EventFloodError(f"more than {self._limits.events} events in one tick")
            raise self.broken
        return self._bus.publish(event)

    def subscribe(self, event_type: type[Any], handler: Callable[[Any], None]) -> Subscription:
        """Subscribes in the behavior's name until it stops. Raises: SubscriptionLeakError."""
        if len(self._bus.subscriptions(self.name)) >= self._limits.subscriptions:
            self.broken = SubscriptionLeakError(
                f"more than {self._limits.subscriptions} subscriptions held; cancel what is not needed"
            )
            raise self.broken

        def watched(event: Any) -> None:
            with self._watch:
                handler(event)

        return self._bus.subscribe(event_type, watched, owner=self.name)

    def release(self) -> None:
        """Ends all subscriptions made in the behavior's name and forgets what it broke."""
        for subscription in self._bus.subscriptions(self.name):
            subscription.cancel()
        self.broken = self.outcome = None


def _own_seed(seed: np.random.SeedSequence, name: str) -> np.random.SeedSequence:
    return np.random.SeedSequence(
        entropy=seed.entropy, spawn_key=(*seed.spawn_key, zlib.crc32(name.encode()))
    )
