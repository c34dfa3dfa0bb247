# ruff: noqa: D100, D103

from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, ControlChanged, Event
from tolman.behaviors.wander import Wander
from tolman.plugins import load_behaviors, load_mediator
from tolman.plugins.testing import ScriptedRobot, Trial, assert_drives_forward, assert_event_order


def test_it_winds_outwards_to_the_rim():
    trial = Trial(load_behaviors(["spiral"])["spiral"](speed=600.0))
    assert_drives_forward(trial.step())
    trial.run(ticks=2000)
    assert trial.behavior.succeeded
    assert trial.behavior.result >= 0.3


def test_it_conforms(check_plugin):
    check_plugin(load_behaviors(["spiral"])["spiral"])


def test_everybody_drives_in_turn():
    spiral = load_behaviors(["spiral"])["spiral"](speed=600.0)
    agent = Agent(ScriptedRobot(), [spiral, Wander()], mediator=load_mediator("round-robin"))
    heard: list[Event] = []
    agent.bus.subscribe(Event, heard.append)
    agent.start("spiral")
    agent.start("wander")
    for _ in range(4000):
        agent.tick()
    winners = [event.winner for event in heard if isinstance(event, ControlChanged)]
    assert winners[:4] == ["spiral", "wander", "spiral", "wander"]
    assert_event_order(heard, BehaviorFinished)
