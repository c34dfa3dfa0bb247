"""Tick listeners: who is called when, and what an end does."""

from __future__ import annotations

import pytest
from tolman.agent import Agent, Context, Listener, Outcome
from tolman.agent.events import Said
from tolman.plugins.testing import ScriptedRobot
from tolman.world.robot import Percept


class Counter(Listener):
    """Counts ticks and what is said; ends after `most` ticks, if it is not told otherwise."""

    def __init__(self, agent: Agent, most: int = 1000, ends: list[Outcome] | None = None) -> None:
        super().__init__(agent, (ends if ends is not None else []).append)
        self.ticks, self.most = 0, most
        self.said: list[str] = []
        self.listen(Said, lambda event: self.said.append(event.text))

    def update(self, percept: Percept, context: Context) -> None:
        self.ticks += 1
        if self.ticks >= self.most:
            self.finish(True, self.ticks, "enough")


@pytest.fixture
def agent() -> Agent:
    return Agent(ScriptedRobot(), [])


def test_one_that_leaves_in_a_tick_makes_no_other_miss_it(agent: Agent) -> None:
    first, second, third = Counter(agent), Counter(agent, most=1), Counter(agent)
    for each in (first, second, third):
        each.start()
    agent.tick()
    agent.tick()
    assert (first.ticks, second.ticks, third.ticks) == (2, 1, 2)


def test_one_attached_in_a_tick_is_called_from_the_next_on(agent: Agent) -> None:
    late = Counter(agent)

    class Starter(Counter):
        def update(self, percept: Percept, context: Context) -> None:
            late.start()

    Starter(agent).start()
    agent.tick()
    assert late.ticks == 0
    agent.tick()
    assert late.ticks == 1


def test_its_end_is_told_once_and_it_may_start_again(agent: Agent) -> None:
    ends: list[Outcome] = []
    counter = Counter(agent, 1, ends)
    assert counter.outcome is None
    counter.start()
    agent.tick()
    agent.tick()
    counter.stop("too late")
    assert ends == [counter.outcome] == [Outcome(True, 1, "enough")]
    counter.start()
    assert (counter.outcome, counter.reason) == (None, "")
    counter.stop()
    assert counter.outcome == Outcome(False, None, "cancelled")


def test_a_closed_one_hears_nothing_and_may_be_closed_again(agent: Agent) -> None:
    counter = Counter(agent)
    counter.start()
    agent.bus.publish(Said(time=0.0, text="first"))
    agent.tick()
    counter.close()
    counter.close()
    agent.bus.publish(Said(time=0.0, text="second"))
    agent.tick()
    assert (counter.ticks, counter.said) == (1, ["first"])


def test_one_attached_twice_is_called_once(agent: Agent) -> None:
    counter = Counter(agent)
    counter.start()
    agent.attach(counter)
    agent.tick()
    assert counter.ticks == 1
