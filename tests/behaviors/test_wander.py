from __future__ import annotations

from tolman.behaviors.wander import Wander
from tolman.plugins.testing import (
    Trial,
    assert_drives_forward,
    assert_in_place,
    assert_states,
    assert_turns,
    percept,
)

STATES = Wander.States


def test_it_drives_ahead_in_the_open() -> None:
    assert_drives_forward(Trial(Wander()).step())


def test_it_turns_away_from_a_wall_ahead_and_goes_on_when_there_is_room() -> None:
    trial = Trial(Wander())
    trial.run(percept(front=0.015, right=0.02), ticks=2)
    assert_turns(trial.proposals[-1], "left")
    assert_in_place(trial.proposals[-1])
    trial.run(None, ticks=100)
    assert_states(trial.states[:3], STATES.STRAIGHT, STATES.TURNING, STATES.STRAIGHT)


def test_it_never_drives_ahead_at_a_wall() -> None:
    trial = Trial(Wander())
    trial.run(percept(front=0.01), ticks=300)
    for proposal in trial.proposals:
        assert_in_place(proposal)


def test_its_way_depends_on_the_seed_alone() -> None:
    ways = []
    for seed in (1, 1, 2):
        trial = Trial(Wander(), seed=seed)
        trial.run(None, ticks=500)
        ways.append(trial.pose)
    assert ways[0] == ways[1]
    assert ways[0] != ways[2]
