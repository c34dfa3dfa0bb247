"""Tick listeners: mappers, navigators, missions, ... watch every tick of an agent and do not drive.

They start behaviors, listen to their reports and end with an `Outcome`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

if TYPE_CHECKING:
    from ..world.robot import Percept
    from .behavior import Context
    from .events import Event, EventBus, Subscription

    E = TypeVar("E", bound=Event)


@dataclass(frozen=True, slots=True)
class Outcome:
    """How something ended: whether it succeeded, what it came to, and why it ended."""

    succeeded: bool
    result: Any = None
    reason: str = ""


class Updated(Protocol):
    """All that the agent's tick needs of what is attached to it."""

    def update(self, percept: Percept, context: Context) -> None:
        """Called once a tick after path integration, before the behaviors propose."""


class TickListener(Updated, Protocol):
    """Something that watches every tick without driving: a mapper, a navigator, a mission, a recorder."""

    def start(self) -> None:
        """Begins; after `restore` it goes on from there."""

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it where it is, unless it has ended; the robot stands still, `outcome` says why."""

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; None before it has started and while it is under way."""

    def state(self) -> dict[str, Any]:
        """What is needed to go on later, as JSON values."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`; `start` then goes on from there."""

    def close(self) -> None:
        """Hears no more. More than once does no harm."""


class Host(Protocol):
    """What a listener needs of the agent it is attached to."""

    @property
    def bus(self) -> EventBus:
        """Where events are heard."""

    def attach(self, listener: Updated) -> None:
        """Has the listener's `update` called once a tick."""

    def detach(self, listener: Updated) -> None:
        """Ends that."""


class Listener:
    """What all tick listeners share: being attached, subscriptions, the outcome. Override what is needed.

    One that starts again, such as a navigator on its next trip, has no outcome until that ends too.
    """

    def __init__(self, host: Host, on_end: Callable[[Outcome], None] = lambda outcome: None) -> None:
        """host: the agent. on_end: told the outcome in the tick in which it is known, but not of a `stop`."""
        self._host = host
        self.on_end = on_end
        self._subscriptions: list[Subscription] = []
        self._outcome: Outcome | None = None

    def listen(self, event_type: type[E], handler: Callable[[E], None]) -> None:
        """Has `handler` called with each event of the type, until `close`."""
        self._subscriptions.append(self._host.bus.subscribe(event_type, handler))

    def start(self) -> None:
        """Attaches it to the agent."""
        self._outcome = None
        self._host.attach(self)

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it with this reason, unless it has ended; `on_end` is not told."""
        if self._outcome is None:
            self._host.detach(self)
            self._outcome = Outcome(False, reason=reason)

    def update(self, percept: Percept, context: Context) -> None:
        """Called once a tick while it is attached."""

    def finish(self, succeeded: bool, result: Any = None, reason: str = "") -> None:
        """Sets the outcome, watches no more ticks and tells its owner, last of all."""
        self._host.detach(self)
        self._outcome = outcome = Outcome(succeeded, result, reason)
        self.on_end(outcome)

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; None before and while it is under way."""
        return self._outcome

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._outcome is not None

    @property
    def reason(self) -> str:
        """Why it ended; empty before."""
        return "" if self._outcome is None else self._outcome.reason

    def belief(self) -> Mapping[int, float]:
        """Node -> probability that the robot is there, while it finds out where it is; to be looked at."""
        return {}

    def state(self) -> dict[str, Any]:
        """Nothing to keep, unless overridden."""
        return {}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Nothing to go back to, unless overridden."""

    def close(self) -> None:
        """Watches no ticks and hears no events any more."""
        self._host.detach(self)
        for subscription in self._subscriptions:
            subscription.cancel()
        self._subscriptions.clear()
