from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent import Candidate, ConfigError, Mediator, PriorityMediator, Proposal
from tolman.agent.arbitration.blend import BlendMediator
from tolman.agent.arbitration.subsumption import SubsumptionMediator, Wire
from tolman.world.robot import STOP, WheelCommand


def candidate(name: str, priority: int, activation: float = 1.0, left: float = 0.0) -> Candidate:
    return Candidate(name, priority, Proposal(WheelCommand(left, left), activation, name))


candidates = st.lists(
    st.builds(
        candidate,
        st.sampled_from("abcdef"),
        st.integers(0, 60),
        st.floats(0.0, 1.0),
        st.floats(-1000.0, 1000.0),
    ),
    max_size=6,
    unique_by=lambda entry: entry.name,
)


@pytest.mark.parametrize("mediator", [PriorityMediator(), BlendMediator(), SubsumptionMediator()])
def test_nobody_drives_when_nobody_proposes(mediator: Mediator) -> None:
    decision = mediator.arbitrate([], "a")
    assert decision.winner is None
    assert decision.command == STOP


def test_higher_priority_wins_however_weakly_it_wants() -> None:
    decision = PriorityMediator().arbitrate([candidate("a", 10, 1.0), candidate("b", 20, 0.1)], "a")
    assert decision.winner == "b"


def test_the_one_in_control_keeps_it_against_an_equal_unless_clearly_wanted_less() -> None:
    mediator = PriorityMediator(hysteresis=0.2)
    close = [candidate("a", 10, 0.5), candidate("b", 10, 0.6)]
    assert mediator.arbitrate(close, "a").winner == "a"
    assert mediator.arbitrate(close, None).winner == "b"
    assert mediator.arbitrate([candidate("a", 10, 0.5), candidate("b", 10, 0.8)], "a").winner == "b"


def test_a_proposal_below_the_threshold_counts_as_not_made() -> None:
    assert PriorityMediator(threshold=0.2).arbitrate([candidate("a", 10, 0.1)], None).winner is None


def test_blend_weights_speeds_by_priority_and_activation() -> None:
    decision = BlendMediator().arbitrate(
        [candidate("a", 10, 1.0, 100.0), candidate("b", 30, 1.0, 300.0)], None
    )
    assert decision.command.left == pytest.approx(250.0)
    assert decision.winner == "b"
    assert "a 25%" in decision.reason


def test_blend_does_not_water_down_a_reflex() -> None:
    decision = BlendMediator().arbitrate(
        [candidate("a", 10, 1.0, 100.0), candidate("r", 50, 1.0, -50.0)], None
    )
    assert decision.command.left == -50.0


def test_suppression_replaces_the_weaker_output_with_the_stronger() -> None:
    mediator = SubsumptionMediator(wires=[Wire("low", "high")])
    decision = mediator.arbitrate([candidate("low", 10), candidate("high", 20)], None)
    assert decision.winner == "low"
    assert "suppresses high" in decision.reason


def test_inhibition_silences_its_target_only() -> None:
    mediator = SubsumptionMediator(wires=[Wire("guard", "high", inhibit=True)])
    wanting = [candidate("guard", 1), candidate("high", 20), candidate("mid", 10)]
    assert mediator.arbitrate(wanting, None).winner == "mid"


def test_a_held_layer_still_acts_on_others_with_the_wheels_at_rest() -> None:
    mediator = SubsumptionMediator(hold_ticks=1)
    strong, weak = candidate("strong", 20, left=500.0), candidate("weak", 10, left=100.0)
    assert mediator.arbitrate([strong, weak], None).command.left == 500.0
    held = mediator.arbitrate([weak], "strong")
    assert (held.winner, held.command) == ("strong", STOP)
    assert mediator.arbitrate([weak], "strong").winner == "weak"


def test_a_reset_network_holds_nobody() -> None:
    mediator = SubsumptionMediator(hold_ticks=5)
    mediator.arbitrate([candidate("strong", 20)], None)
    mediator.reset()
    assert mediator.arbitrate([candidate("weak", 10)], None).winner == "weak"


@given(candidates, st.one_of(st.none(), st.sampled_from("abcdef")))
def test_every_strategy_picks_one_who_proposed_and_a_finite_command(
    wanting: list[Candidate], previous: str | None
) -> None:
    names = {entry.name for entry in wanting}
    for mediator in (PriorityMediator(), BlendMediator(), SubsumptionMediator(wires=[Wire("a", "b")])):
        decision = mediator.arbitrate(wanting, previous)
        assert decision.winner is None or decision.winner in names
        assert math.isfinite(decision.command.left)


@given(candidates)
def test_the_order_of_the_candidates_changes_no_winner(wanting: list[Candidate]) -> None:
    shuffled = sorted(wanting, key=lambda entry: entry.name)
    for mediator in (PriorityMediator(), BlendMediator(), SubsumptionMediator()):
        assert mediator.arbitrate(wanting, None).winner == mediator.arbitrate(shuffled, None).winner


@pytest.mark.parametrize("kind", [PriorityMediator, BlendMediator, SubsumptionMediator])
def test_a_wrong_option_is_refused_with_the_mediators_name_and_what_it_takes(kind: type[Any]) -> None:
    with pytest.raises(ConfigError, match=f"mediator {kind.name}: unknown setting 'sharp'.*known: "):
        kind(sharp=1)


def test_wires_can_be_given_as_a_settings_file_has_them() -> None:
    mediator = SubsumptionMediator(wires=[{"source": "low", "target": "high"}])
    assert mediator.config.wires == (Wire("low", "high"),)
    with pytest.raises(ConfigError, match=r"mediator subsumption: wires\[0\]: unknown field 'from'"):
        SubsumptionMediator(wires=[{"from": "low"}])


def test_a_sharp_blend_leaves_more_to_the_strongest() -> None:
    given = [candidate("a", 10, 1.0), candidate("b", 20, 1.0)]
    even, sharp = BlendMediator().arbitrate(given, None), BlendMediator(sharpness=4.0).arbitrate(given, None)
    assert "b 67%" in even.reason
    assert "b 94%" in sharp.reason
