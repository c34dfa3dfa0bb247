from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar

import pytest
from tolman.agent import Behavior, BehaviorContractError, ConfigError, Context, Proposal, Transition
from tolman.world.robot import STOP, Percept


@dataclass(frozen=True, slots=True)
class Speeds:
    """speed: steps/s."""

    speed: float = 100.0
    legs: int = 3
    careful: bool = True


class Light(Behavior):
    class States(Enum):
        RED = "red"
        GREEN = "green"

    name = "light"
    initial = States.RED
    transitions: ClassVar[tuple[Transition, ...]] = (
        Transition("go", States.RED, States.GREEN),
        Transition("halt", (States.GREEN, States.RED), States.RED),
    )
    Config = Speeds
    resets = 0

    def on_reset(self) -> None:
        self.resets += 1

    def red(self, percept: Percept, context: Context) -> Proposal | None:
        return Proposal(STOP)

    def green(self, percept: Percept, context: Context) -> Proposal | None:
        return Proposal(STOP)


def test_a_trigger_leads_to_its_target_state() -> None:
    light = Light()
    light.fire("go")
    assert light.state is Light.States.GREEN


def test_a_trigger_that_is_not_allowed_names_those_that_are() -> None:
    light = Light()
    light.fire("go")
    with pytest.raises(BehaviorContractError, match=r"no transition 'go' from state GREEN; known here: halt"):
        light.fire("go")


def test_reset_leads_back_to_the_start_and_forgets_the_result() -> None:
    light = Light()
    light.fire("go")
    light.finish(True, "arrived", result=7)
    light.reset()
    assert light.state is Light.States.RED
    assert (light.finished, light.succeeded, light.reason, light.result) == (False, False, "", None)
    assert light.resets == 2


def test_two_behaviors_of_a_class_have_states_of_their_own() -> None:
    one, other = Light(), Light()
    one.fire("go")
    assert other.state is Light.States.RED


def test_settings_are_taken_by_name_or_as_a_config() -> None:
    assert Light(speed=5.0).config == Speeds(speed=5.0)
    assert Light(Speeds(legs=1)).config.legs == 1


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"sped": 1.0}, r"light: unknown setting 'sped'.*did you mean 'speed'.*careful, legs, speed"),
        ({"speed": "fast"}, r"light: speed must be a finite number, not 'fast'"),
        ({"speed": float("nan")}, r"light: speed must be a finite number, not nan"),
        ({"legs": 1.5}, r"light: legs must be a whole number, not 1.5"),
        ({"legs": True}, r"light: legs must be a whole number, not True"),
        ({"careful": "no"}, r"light: careful must be true or false, not 'no'"),
    ],
)
def test_a_wrong_setting_is_refused_with_its_name(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Light(**settings)


def test_a_whole_number_does_for_a_float() -> None:
    assert Light(speed=5).config.speed == 5.0


def test_a_config_of_another_class_is_refused() -> None:
    with pytest.raises(ConfigError, match="config must be a Speeds, not dict"):
        Light({"speed": 1.0})


def test_a_class_without_name_is_refused() -> None:
    class Nameless(Light):
        name = ""

    with pytest.raises(BehaviorContractError, match="Nameless: declare a `name`"):
        Nameless()


def test_a_transition_to_a_foreign_state_is_refused() -> None:
    class Other(Enum):
        BLUE = "blue"

    class Confused(Light):
        transitions = (Transition("go", Light.States.RED, Other.BLUE),)

    with pytest.raises(BehaviorContractError, match=r"'go' names <Other\.BLUE"):
        Confused()
