from __future__ import annotations

from dataclasses import dataclass

import pytest
from tolman.agent.events import BehaviorStarted, Event, EventBus, Lost


@dataclass(frozen=True, slots=True, kw_only=True)
class Rang(Event):
    node: int


def test_events_are_delivered_in_the_order_in_which_they_were_published() -> None:
    bus, heard = EventBus(), list[Event]()
    bus.subscribe(Event, heard.append)
    first, second = Rang(time=1.0, node=3), Lost(time=1.0, reason="no wall")
    bus.publish(first)
    bus.publish(second)
    assert heard == []
    assert bus.deliver() == 2
    assert heard == [first, second]


def test_a_handler_hears_its_type_and_subtypes_only() -> None:
    bus, heard = EventBus(), list[Event]()
    bus.subscribe(Rang, heard.append)
    bus.publish(Lost(time=0.0, reason=""))
    bus.deliver()
    assert heard == []


def test_what_a_handler_publishes_waits_for_the_next_delivery() -> None:
    bus, heard = EventBus(), list[Event]()

    def echo(event: Rang) -> None:
        bus.publish(Lost(time=event.time, reason="echo"))

    bus.subscribe(Rang, echo)
    bus.subscribe(Lost, heard.append)
    bus.publish(Rang(time=0.0, node=1))
    bus.deliver()
    assert heard == []
    bus.deliver()
    assert len(heard) == 1


def test_a_cancelled_subscription_hears_no_more() -> None:
    bus, heard = EventBus(), list[Event]()
    subscription = bus.subscribe(Lost, heard.append)
    subscription.cancel()
    subscription.cancel()
    bus.publish(Lost(time=0.0, reason=""))
    bus.deliver()
    assert heard == []


def test_a_plugins_raising_handler_is_removed_and_the_others_still_hear() -> None:
    bus, heard = EventBus(), list[Event]()

    def bad(event: Lost) -> None:
        raise RuntimeError("broken")

    bus.subscribe(Lost, bad, owner="plugin")
    bus.subscribe(Lost, heard.append)
    bus.publish(Lost(time=0.0, reason=""))
    bus.deliver()
    assert len(heard) == 1
    assert bus.subscriptions("plugin") == []


def test_a_raising_handler_of_the_agents_own_ends_the_run() -> None:
    bus = EventBus()

    def bad(event: Lost) -> None:
        raise RuntimeError("broken")

    bus.subscribe(Lost, bad)
    bus.publish(Lost(time=0.0, reason=""))
    with pytest.raises(RuntimeError):
        bus.deliver()


def test_events_are_immutable() -> None:
    event = BehaviorStarted(time=0.0, behavior="a")
    with pytest.raises(AttributeError):
        event.time = 1.0  # type: ignore[misc]
