"""What a behavior is made of besides its methods: proposals, the table, children; and the check of them."""

from __future__ import annotations

from dataclasses import dataclass, is_dataclass
from enum import Enum
from typing import Any

from ..files.messages import LONGEST, quoted, unknown
from ..world.robot import WheelCommand
from .errors import BehaviorContractError

HIGHEST = 1000
"""The highest priority; the lowest is its negative."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """How a behavior would drive in this tick.

    command: wheel speeds (steps/s). activation: how much it wants control, in (0, 1].
    reason: a few words for people who read the run later.
    """

    command: WheelCommand
    activation: float = 1.0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Transition:
    """One row of a behavior's table: `trigger` leads from any of `sources` to `target`.

    when: the name of a method that says whether the row holds; of several rows with the same trigger and
    source the first that holds is taken. "" holds always.
    """

    trigger: str
    sources: Enum | tuple[Enum, ...]
    target: Enum
    when: str = ""

    @property
    def origins(self) -> tuple[Enum, ...]:
        """The sources as a tuple."""
        return self.sources if isinstance(self.sources, tuple) else (self.sources,)


class Child:
    """What a behavior declares of one that it drives by: its class, and the settings it insists on.

    What the parent sets here wins; then the user's setting for that behavior; then the default.
    """

    __slots__ = ("cls", "settings")

    def __init__(self, cls: type[Any], **settings: Any) -> None:
        """settings: fields of the class's `Config`."""
        self.cls, self.settings = cls, settings


def declared(child: Any) -> Child:
    """What a behavior says of a child; a class alone insists on no settings."""
    return child if isinstance(child, Child) else Child(child)


def table(cls: type[Any]) -> dict[tuple[Enum, str], tuple[Transition, ...]]:
    """The rows by source and trigger, in the order in which they are tried."""
    found: dict[tuple[Enum, str], tuple[Transition, ...]] = {}
    for row in cls.transitions:
        for source in row.origins:
            found[source, row.trigger] = (*found.get((source, row.trigger), ()), row)
    return found


def check(cls: type[Any], base: type[Any]) -> None:
    """Raises BehaviorContractError, naming class and lack, if the class does not declare what it must.

    base: the class of all behaviors.
    """
    name, priority = cls.name, cls.priority
    if not name or type(name) is not str or not name.isprintable() or len(name) > LONGEST:
        raise BehaviorContractError(f"{cls.__name__}: declare a `name`, such as name = 'wall-following'")
    if type(priority) is not int or abs(priority) > HIGHEST:
        raise BehaviorContractError(
            f"{name}: priority = {quoted(priority)}: give a whole number of at most {HIGHEST}; "
            "higher is stronger"
        )
    states = getattr(cls, "States", None)
    if not (isinstance(states, type) and issubclass(states, Enum) and len(states)):
        raise BehaviorContractError(f"{cls.name}: declare `States`, an Enum with at least one member")
    initial = getattr(cls, "initial", None)
    if not isinstance(initial, states):
        raise BehaviorContractError(f"{cls.name}: `initial` must be a member of States, not {initial!r}")
    _check_table(cls)
    _check_methods(cls, base)
    _check_goal(cls)
    _check_children(cls, base)


def _check_table(cls: type[Any]) -> None:
    for row in cls.transitions:
        for state in (*row.origins, row.target):
            if not isinstance(state, cls.States):
                raise BehaviorContractError(
                    f"{cls.name}: transition {row.trigger!r} names {state!r}, not in States"
                )
        if row.when and not callable(getattr(cls, row.when, None)):
            raise BehaviorContractError(
                f"{cls.name}: transition {row.trigger!r} holds when `{row.when}`, which is no method"
            )
    for (source, trigger), rows in table(cls).items():
        if not all(row.when for row in rows[:-1]):
            raise BehaviorContractError(
                f"{cls.name}: two transitions {trigger!r} from {source.name}: give the first one a `when`"
            )


def _check_methods(cls: type[Any], base: type[Any]) -> None:
    if cls.propose is not base.propose:
        raise BehaviorContractError(f"{cls.name}: write a method a state; `propose` is the base class's")
    names = {state.name.lower(): state for state in cls.States}
    for name, state in names.items():
        if hasattr(base, name) or name in ("config", "goal", "finished", "succeeded", "reason", "result"):
            raise BehaviorContractError(
                f"{cls.name}: state {state.name} would need a method `{name}`, which every behavior has: "
                "name the state otherwise"
            )
        if not callable(getattr(cls, name, None)):
            raise BehaviorContractError(
                f"{cls.name}: state {state.name} has no method: write `def {name}(self, percept, context)`"
            )
    for name in dir(cls):
        entered = name.removeprefix("on_enter_")
        if entered != name and entered not in names:
            raise BehaviorContractError(
                f"{cls.name}: `{name}` is for no state: {unknown('state', entered, names)}"
            )


def _check_goal(cls: type[Any]) -> None:
    goal = cls.Goal
    if goal is None:
        return
    if not (isinstance(goal, type) and is_dataclass(goal) and goal.__dataclass_params__.frozen):  # type: ignore[attr-defined]
        raise BehaviorContractError(f"{cls.name}: `Goal` must be a frozen dataclass or None, not {goal!r}")
    if cls.example is not None and not isinstance(cls.example, goal):
        raise BehaviorContractError(f"{cls.name}: `example` must be a {goal.__name__}, not {cls.example!r}")


def _check_children(cls: type[Any], base: type[Any]) -> None:
    for role, child in cls.children.items():
        made = declared(child)
        if not (isinstance(made.cls, type) and issubclass(made.cls, base)):
            raise BehaviorContractError(f"{cls.name}: child {role!r} must be a behavior class, not {child!r}")
        if not role.isidentifier() or hasattr(cls, role):
            raise BehaviorContractError(f"{cls.name}: a child cannot be called {role!r}: choose another name")
