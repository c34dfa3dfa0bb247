"""What happens, as frozen dataclasses, and the one bus that delivers them once a tick.

What a handler publishes while events are delivered waits for the next tick, so the order of events,
and with it the run, depends on nothing but what was published.
"""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from ..files.interrupts import ends_run

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something that happened. time: simulated seconds since the start of the run."""

    time: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlChanged(Event):
    """Another behavior drives from this tick on, and why.

    wanted: name -> activation of all that proposed. reasons: name -> what each said it wanted it for.
    """

    previous: str | None
    winner: str | None
    reason: str
    wanted: Mapping[str, float] = field(default_factory=dict)
    reasons: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorStarted(Event):
    """A behavior was given a goal and takes part in arbitration from the next tick on."""

    behavior: str
    goal: Any = None


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorFinished(Event):
    """A behavior reached its goal (`succeeded`) or gave it up; it proposes no more until started again."""

    behavior: str
    succeeded: bool
    reason: str = ""
    result: Any = None


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorFaulted(Event):
    """A behavior was stopped because it broke the contract; `disabled` says that it stays so."""

    behavior: str
    state: str
    fault: str
    disabled: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MediatorFaulted(Event):
    """The mediator broke its contract; arbitration by priority takes its place for the rest of the run."""

    mediator: str
    fault: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerReached(Event):
    """The wall follower stands at a corner, before turning; or it passes a bend.

    kind: "concave" (a wall ahead), "convex" (the wall at the side ended) or "bend" (the wall has turned by so
    much without a corner). path_length: m driven since the last corner or bend, turns in place not counted.
    heading: rad, path-integrated, of the wall just followed. turn: rad, counter-clockwise, that the robot is
    going to turn in place to follow the next wall, as far as it can tell from here.
    max_heading_change: rad, by how much the direction of the wall just followed changed within 10 cm, at
    most; walls that are straight have none. unobserved_length: m of the path, the last, on which nothing
    told the wall's direction: before a convex corner it has ended already, and `heading` is that of before.
    number: of the corner in this run, from 1 on, given by the bus when it is published: others say by it
    which corner they mean.
    """

    side: str
    kind: str
    path_length: float
    heading: float
    turn: float
    max_heading_change: float = 0.0
    unobserved_length: float = 0.0
    number: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class WallMet(Event):
    """The wall follower has followed enough of a wall to know its direction.

    heading: rad, path-integrated, of the wall. After a corner: `CornerReached` told that of the wall before.
    path_length: m driven since the last corner or bend.
    """

    side: str
    heading: float
    path_length: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeCreated(Event):
    """The map has a new node. corner: its kind. met: number of the `CornerReached` that it was made for."""

    node: int
    corner: str
    met: int


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeCommitted(Event):
    """A node, its arcs and its local map are complete and may be stored; the robot stands at it."""

    node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcAdded(Event):
    """Two nodes were joined by an arc and its reverse. distance: m."""

    source: int
    target: int
    side: str
    distance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalMapBuilt(Event):
    """The space and the views around a node were explored and its self-organizing maps trained."""

    node: int
    positions: int
    panoramas: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopClosed(Event):
    """The robot recognized that it was back at `node` when it met corner number `met`.

    past: m, how far beyond the node it was along the wall, where the node is on a bend.
    """

    node: int
    met: int
    past: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class NodePassed(Event):
    """Navigation holds that the robot stands at `node`, on its way or at its end."""

    node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeReached(Event):
    """Navigation holds that the robot stands at `node`, the end of its trip, in the transition pose."""

    node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Localized(Event):
    """The robot, not told where it was, found that it stands at `node`."""

    node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Lost(Event):
    """The robot no longer knows where it is."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Stuck(Event):
    """The wheels turn and nothing that is sensed changes. given_up: freeing it was tried, in vain."""

    reason: str
    given_up: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Freed(Event):
    """A stuck robot moves again. attempts: how many it took."""

    attempts: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StepStarted(Event):
    """A mission began a step. path: its place in the mission, as 2.1 for the first in the second."""

    path: str
    step: str


@dataclass(frozen=True, slots=True, kw_only=True)
class StepEnded(Event):
    """A mission's step is done, or failed for a reason."""

    path: str
    step: str
    succeeded: bool
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Said(Event):
    """What a mission has to say."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionEnded(Event):
    """The mission is over: done, failed, or cancelled."""

    mission: str
    status: str
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PluginEvent(Event):
    """What a plugin has to say that no other event does. data: JSON-like values only."""

    name: str
    data: Mapping[str, Any] = field(default_factory=dict)


E = TypeVar("E", bound=Event)
Handler = Callable[[Any], None]


class Subscription:
    """A handle on one subscription; `cancel` ends it."""

    __slots__ = ("_bus", "event_type", "handler", "owner")

    def __init__(self, bus: EventBus, event_type: type[Event], handler: Handler, owner: str) -> None:
        """Made by `EventBus.subscribe`."""
        self._bus = bus
        self.event_type = event_type
        self.handler = handler
        self.owner = owner

    def cancel(self) -> None:
        """Ends the subscription; more than once does no harm."""
        self._bus.remove(self)


class EventBus:
    """Queues events and delivers them in the order in which they were published."""

    def __init__(
        self, limit_per_tick: int = 1000, on_fault: Callable[[str, BaseException], None] | None = None
    ) -> None:
        """`limit_per_tick`: events beyond it are refused, so that a flood cannot stop the run.

        `on_fault`: told the owner and the fault when a handler raises.
        """
        self._on_fault = on_fault
        self._limit = limit_per_tick
        self._queue: list[Event] = []
        self._handlers: dict[type[Event], list[Subscription]] = defaultdict(list)
        self.dropped = 0
        self.corners = 0
        """Number of the last `CornerReached`."""

    def subscribe(self, event_type: type[E], handler: Callable[[E], None], owner: str = "") -> Subscription:
        """Has `handler` called with each event of the type (or a subtype) at the end of its tick."""
        subscription = Subscription(self, event_type, handler, owner)
        self._handlers[event_type].append(subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """Ends one subscription."""
        entries = self._handlers.get(subscription.event_type, [])
        if subscription in entries:
            entries.remove(subscription)

    def subscriptions(self, owner: str) -> list[Subscription]:
        """The subscriptions made in this owner's name."""
        return [entry for entries in self._handlers.values() for entry in entries if entry.owner == owner]

    def publish(self, event: Event) -> bool:
        """Queues an event; False if the tick's limit is reached and it was dropped."""
        if len(self._queue) >= self._limit:
            self.dropped += 1
            return False
        if isinstance(event, CornerReached):
            self.corners += 1
            event = replace(event, number=self.corners)
        self._queue.append(event)
        return True

    def deliver(self) -> int:
        """Delivers what is queued now and returns how many events; called once a tick by the agent.

        A handler that raises is removed and the fault logged: the other handlers still hear the event.
        """
        if not self._queue:
            return 0
        queue, self._queue = self._queue, []
        for event in queue:
            for event_type in type(event).__mro__[:-1]:
                for subscription in tuple(self._handlers.get(event_type, ())):
                    self._call(subscription, event)
        return len(queue)

    def _call(self, subscription: Subscription, event: Event) -> None:
        if not subscription.owner:
            # The agent's own parts: a fault of theirs must end the run, not be hidden.
            subscription.handler(event)
            return
        try:
            subscription.handler(event)
        except BaseException as fault:
            if ends_run(fault):
                raise
            subscription.cancel()
            kind = type(event).__name__
            _log.error(
                "handler of %s for %s raised %s and was removed",
                subscription.owner,
                kind,
                type(fault).__name__,
            )
            if self._on_fault is not None:
                self._on_fault(subscription.owner, fault)
