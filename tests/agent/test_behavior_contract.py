from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, ClassVar

import pytest
from tolman.agent import (
    Agent,
    Behavior,
    BehaviorContractError,
    Child,
    ConfigError,
    Context,
    GoalError,
    Proposal,
    Transition,
)
from tolman.agent.codec import dumps, loads
from tolman.agent.events import Event, PluginEvent
from tolman.plugins.testing import ScriptedRobot, Trial, event_of
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


@dataclass(frozen=True, slots=True)
class Shine:
    """seconds: how long. color: "red" or "green"."""

    seconds: float
    color: Annotated[str, ("red", "green")] = "red"


class Lamp(Light):
    """Is warm from the second time on."""

    name = "lamp"
    Goal = Shine
    transitions: ClassVar[tuple[Transition, ...]] = (
        Transition("go", Light.States.RED, Light.States.GREEN, when="is_warm"),
        Transition("go", Light.States.RED, Light.States.RED),
        Transition("stay", Light.States.GREEN, Light.States.GREEN, when="is_warm"),
    )
    warm = False

    def is_warm(self) -> bool:
        return self.warm

    def on_enter_green(self, context: Context) -> None:
        context.publish(PluginEvent(time=context.time, name="green"))


def test_the_first_row_whose_condition_holds_is_taken_and_its_entry_action_runs() -> None:
    trial = Trial(Lamp(), goal=Shine(1.0))
    lamp: Any = trial.behavior
    lamp.fire("go")
    assert lamp.state is Light.States.RED
    lamp.warm = True
    lamp.fire("go")
    trial.step()
    assert lamp.state.name == "GREEN"
    assert event_of(trial.events, PluginEvent).name == "green"
    lamp.warm = False
    with pytest.raises(
        BehaviorContractError, match=r"no transition 'stay' from state GREEN holds now: is_warm"
    ):
        lamp.fire("stay")


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (None, "lamp needs a Shine goal, not None"),
        (7, "lamp needs a Shine goal, not 7"),
        ({}, "lamp: goal: Shine needs seconds"),
        ({"secnds": 1}, r"lamp: goal: unknown field 'secnds'; did you mean 'seconds'\?"),
        ({"seconds": "long"}, "lamp: goal: seconds must be a finite number, not 'long'"),
        (Shine(1.0, "blue"), "lamp: goal: color must be red or green, not 'blue'"),
    ],
)
def test_a_goal_that_does_not_fit_is_refused_in_one_line(goal: Any, said: str) -> None:
    with pytest.raises(GoalError, match=said):
        Trial(Lamp(), goal=goal)


def test_a_goal_is_given_as_its_class_its_fields_or_as_it_was_recorded() -> None:
    for goal in (Shine(2.0), {"seconds": 2.0}, loads(dumps(Shine(2.0)))):
        assert Trial(Lamp(), goal=goal).behavior.goal == Shine(2.0)


def test_a_behavior_without_goals_takes_none() -> None:
    with pytest.raises(GoalError, match="light takes no goal, not 7"):
        Trial(Light(), goal=7)


def declared(**body: Any) -> type[Light]:
    return type("Odd", (Light,), {"name": "odd", **body})


class More(Enum):
    RED = "red"
    BLUE = "blue"


class Start(Enum):
    START = "start"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            {"States": More, "initial": More.RED, "transitions": ()},
            "state BLUE has no method: write `def blue",
        ),
        (
            {"States": Start, "initial": Start.START, "transitions": ()},
            "state START would need a method `start`",
        ),
        (
            {"on_enter_gren": lambda self, context: None},
            "`on_enter_gren` is for no state.*did you mean 'green'",
        ),
        ({"propose": lambda self, percept, context: None}, "write a method a state; `propose` is the base"),
        ({"Goal": 7}, "`Goal` must be a frozen dataclass or None, not 7"),
        ({"children": {"lamp": 7}}, "child 'lamp' must be a behavior class, not 7"),
        ({"children": {"fire": Lamp}}, "a child cannot be called 'fire'"),
        (
            {"transitions": (Transition("go", Light.States.RED, Light.States.GREEN, when="is_wram"),)},
            "'go' holds when `is_wram`, which is no method",
        ),
        (
            {"transitions": (Transition("go", Light.States.RED, Light.States.GREEN),) * 2},
            "two transitions 'go' from RED",
        ),
    ],
)
def test_a_wrong_declaration_is_refused_in_one_line_with_the_class(body: dict[str, Any], said: str) -> None:
    with pytest.raises(BehaviorContractError, match=f"odd: .*{said}"):
        declared(**body)()


def test_a_parent_hears_its_child_first_and_its_settings_win() -> None:
    class Porch(Light):
        name = "porch"
        children: ClassVar = {"lamp": Child(Lamp, legs=7)}
        lamp: Lamp

        def on_start(self, context: Context) -> None:
            self.heard: list[Event] = []
            self.lamp.start(Shine(1.0), context)
            self.lamp.warm = True
            self.lamp.fire("go")

        def on_child_event(self, child: Behavior, event: Event, context: Context) -> None:
            self.heard.append(event)

    porch = Porch()
    agent = Agent(ScriptedRobot(), [porch, Lamp(speed=5.0, legs=1)])
    published: list[Event] = []
    agent.bus.subscribe(PluginEvent, published.append)
    agent.start("porch")
    agent.tick()
    assert porch.lamp.config == Speeds(speed=5.0, legs=7)
    assert [type(event) for event in porch.heard] == [PluginEvent]
    assert published == []


def test_a_behavior_and_an_agent_say_what_they_do() -> None:
    agent = Agent(ScriptedRobot(), [Light()])
    agent.start("light")
    agent.tick()
    assert repr(agent.behavior("light")) == "<Light light: RED>"
    assert repr(agent) == "<Agent at 0.0 s, light drives; active: light; of 1>"
