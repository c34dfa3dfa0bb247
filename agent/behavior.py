"""The behavior contract: a state machine that, once a tick, may propose how to drive.

A behavior is a subclass of `Behavior`. It declares

- `name`: how missions, configuration and events call it;
- `priority`: higher wins under the default mediator (the built-in ones: obstacle avoidance 50, local
  exploration and local navigation 40, position correction 30, go-to-node 20, wall following 10);
- `States`: an Enum; `initial`: the state after `reset`; `transitions`: the table, as data;
- `Config`: a frozen dataclass of settings with defaults, units in its docstring;
- `Goal`: a frozen dataclass of what it is asked to do, None for a behavior that takes no goal;
- `children`: the behaviors it drives by, which the agent makes and configures for it;

and has one method a state, named after it in lower case, and entry actions where it needs them:

    def turning(self, percept, context) -> Proposal | None: ...     # once a tick while in TURNING
    def on_enter_turning(self, context) -> None: ...                # once, when a transition leads there

In each tick `on_tick` runs first, then the method of the state the behavior is in after that. A transition
that the method takes is in force at once (`state`, entry action); the new state's method runs from the next
tick on, unless this one hands over: `return self.turning(percept, context)`.

A behavior never blocks, never sleeps, never asks the clock: the time is `context.time`, randomness
`context.rng`.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, ClassVar

import numpy as np

from ..world.robot import Image, Percept, Pose, RobotGeometry, WheelCommand
from .declarations import Child, Proposal, Transition, check, declared, table
from .errors import AgentError, BehaviorContractError, GoalError
from .events import Event, Subscription
from .fields import configured, fitted, needs_values

__all__ = ["Behavior", "Child", "Context", "NoConfig", "Proposal", "Transition", "check_declarations"]


def _no_bus(event_type: type[Any], handler: Callable[[Any], None]) -> Subscription:
    raise AgentError("this context has no bus to subscribe to")


@dataclass(slots=True)
class Context:
    """What a behavior may know besides the percept; the agent renews it every tick.

    pose: path-integrated (m, rad). distance, turn: this tick's share of it (m, rad).
    in_control: whether this behavior's proposal drove in the last tick.
    publish: queues an event. look: takes a camera image (height, width) now, while standing still.
    subscribe: (event type, handler); the agent ends it when the behavior stops. Handlers are called at the
    end of a tick.
    """

    geometry: RobotGeometry
    publish: Callable[[Event], bool]
    look: Callable[[], Image]
    rng: np.random.Generator
    time: float = 0.0
    pose: Pose = field(default_factory=Pose)
    distance: float = 0.0
    turn: float = 0.0
    in_control: bool = False
    subscribe: Callable[[type[Any], Callable[[Any], None]], Subscription] = _no_bus


@dataclass(frozen=True, slots=True)
class NoConfig:
    """The configuration of a behavior that has none."""


class Behavior(ABC):
    """Base class of all behaviors. See the module's text for what a subclass declares."""

    name: ClassVar[str] = ""
    priority: ClassVar[int] = 0
    States: ClassVar[type[Enum]]
    initial: ClassVar[Enum]
    transitions: ClassVar[tuple[Transition, ...]] = ()
    Config: ClassVar[type[Any]] = NoConfig
    Goal: ClassVar[type[Any] | None] = None
    children: ClassVar[Mapping[str, Child | type[Behavior]]] = {}
    """The behaviors it drives by, each by the attribute under which it finds them."""
    example: ClassVar[Any] = None
    """A goal for `tolman plugins check`, where some field of `Goal` has no default."""
    restarts: ClassVar[bool] = False
    """Whether the agent starts it again by itself after a fault, until it is disabled: for reflexes."""
    slow_start: ClassVar[bool] = False
    """Whether its start and stop are outside the time budget, as where a process has to begin first."""

    def __init__(self, config: Any = None, **settings: Any) -> None:
        """`config`: an instance of `Config`; or give its fields by keyword.

        Raises: BehaviorContractError if the class lacks a declaration, ConfigError for a wrong setting.
        """
        cls = type(self)
        check_declarations(cls)
        self.config: Any = configured(cls.name, cls.Config, config, settings)
        self.goal: Any = None
        self.finished = False
        self.succeeded = False
        self.reason = ""
        self.result: Any = None
        self.__state: Enum = cls.initial
        self.__parent: Behavior | None = None
        self.__context: Context | None = None
        self.__outer: Context | None = None
        self.__table = table(cls)
        self.__methods = {state: getattr(self, state.name.lower()) for state in cls.States}
        self.__children: tuple[Behavior, ...] = ()
        self.adopt({})
        self.reset()

    # --- to override, besides the states' methods and `on_enter_` ones ---------------------------------

    def on_tick(self, percept: Percept, context: Context) -> None:  # noqa: B027
        """What is kept up whatever the state. Called once a tick, before the state's method."""

    def on_start(self, context: Context) -> None:  # noqa: B027
        """Prepares for `self.goal`. Called once, before the first tick, in the initial state."""

    def on_reset(self) -> None:  # noqa: B027
        """Forgets everything but the configuration. Called by the constructor and before each start."""

    def on_stop(self, context: Context) -> None:  # noqa: B027
        """Lets go of what it holds. Called once when it finished, was stopped or broke the contract."""

    def on_child_event(self, child: Behavior, event: Event, context: Context) -> None:
        """Hears what a child publishes, first and alone; called at once. This one passes it on."""
        context.publish(event)

    # --- to use --------------------------------------------------------------------------------------

    @property
    def state(self) -> Any:
        """The state it is in, a member of `States`."""
        return self.__state

    def fire(self, trigger: str) -> None:
        """Takes the transition of that name and runs the new state's entry action.

        Raises: BehaviorContractError if there is none from here, or none whose condition holds.
        """
        rows = self.__table.get((self.__state, trigger), ())
        for row in rows:
            if not row.when or getattr(self, row.when)():
                return self.__take(row)
        here = f"{self.name}: no transition {trigger!r} from state {self.__state.name}"
        if rows:
            raise BehaviorContractError(f"{here} holds now: {', '.join(row.when for row in rows)}")
        known = sorted(name for source, name in self.__table if source is self.__state)
        raise BehaviorContractError(f"{here}; known here: {', '.join(known) or 'none'}")

    def proposal(self, command: WheelCommand, reason: str = "") -> Proposal:
        """A proposal of full activation. reason: "" is what the state at work in this tick is called."""
        if not reason:
            value = self.__acting.value
            reason = value if isinstance(value, str) else self.__acting.name.lower()
        return Proposal(command, 1.0, reason)

    def finish(self, succeeded: bool, reason: str = "", result: Any = None) -> None:
        """Says that the goal is reached or given up; the agent publishes `BehaviorFinished` with it."""
        self.finished, self.succeeded, self.reason, self.result = True, succeeded, reason, result

    # --- called by the agent, a trial, or the behavior that drives by this one ---------------------------

    def start(self, goal: Any, context: Context) -> None:
        """Resets it and gives it a goal: a `Goal`, a mapping of its fields, or None for its defaults.

        Raises: GoalError for a goal that does not fit.
        """
        self.reset()
        self.goal = self.fitted_goal(goal)
        if self.__parent is not None:
            self.__outer, context = context, replace(context, publish=self.__tell)
        self.__context = context
        self.__method = self.__methods[self.__state]
        self.on_start(context)

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """One tick: `on_tick`, then the state's method. Returns how to drive, None to have no say."""
        if self.__parent is not None:
            context = self.__inherit(context)
        self.__context = context
        self.on_tick(percept, context)
        self.__acting = self.__state
        proposal: Proposal | None = self.__method(percept, context)
        return proposal

    def stop(self, context: Context) -> None:
        """Ends it, and the behaviors it drives by."""
        self.on_stop(context)
        for child in self.__children:
            child.stop(context)

    def reset(self) -> None:
        """Back to the initial state, as if new."""
        for child in self.__children:
            child.reset()
        self.__state = self.__acting = type(self).initial
        self.__method = self.__not_started
        self.finished = self.succeeded = False
        self.reason, self.result, self.goal = "", None, None
        self.__context = None
        self.on_reset()

    def adopt(self, configs: Mapping[str, Any]) -> None:
        """Makes the behaviors that it drives by. configs: the user's configuration, by behavior's name."""
        self.__children = tuple(self.__made(role, configs) for role in type(self).children)

    def fitted_goal(self, goal: Any) -> Any:
        """The goal as a checked `Goal`. Raises: GoalError."""
        cls = type(self).Goal
        if cls is None:
            if goal is not None:
                raise GoalError(f"{self.name} takes no goal, not {goal!r}")
            return None
        if goal is None and not needs_values(cls):
            goal = {}
        if not isinstance(goal, cls | Mapping):
            article = "an" if cls.__name__[0] in "AEIOU" else "a"
            raise GoalError(f"{self.name} needs {article} {cls.__name__} goal, not {goal!r}")
        try:
            return fitted(cls, goal, f"{self.name}: goal")
        except ValueError as fault:
            raise GoalError(str(fault)) from fault

    def __repr__(self) -> str:
        """`<WallFollowing wall-following: FOLLOW, Follow(side='right')>`."""
        words = [self.__state.name]
        if self.goal is not None:
            words.append(repr(self.goal))
        if self.finished:
            words.append("succeeded" if self.succeeded else f"failed ({self.reason})")
        return f"<{type(self).__name__} {self.name}: {', '.join(words)}>"

    # --- how it is done ------------------------------------------------------------------------------

    def _enter_state(self, state: Enum) -> None:
        self.__state, self.__method = state, self.__methods[state]

    def __not_started(self, percept: Percept, context: Context) -> Proposal | None:
        raise BehaviorContractError(f"{self.name} was asked before it was started")

    def __take(self, row: Transition) -> None:
        self._enter_state(row.target)
        action = getattr(self, f"on_enter_{row.target.name.lower()}", None)
        if action is not None:
            if self.__context is None:
                raise BehaviorContractError(f"{self.name}: {row.trigger!r} was fired before it was started")
            action(self.__context)

    def __made(self, role: str, configs: Mapping[str, Any]) -> Behavior:
        child_of = declared(type(self).children[role])
        cls, users = child_of.cls, configs.get(child_of.cls.name)
        if not isinstance(users, cls.Config):
            users = None
        config = replace(users, **child_of.settings) if users is not None else None
        child: Behavior = cls(config) if config is not None else cls(**child_of.settings)
        child.__parent = self
        child.adopt(configs)
        setattr(self, role, child)
        return child

    def __inherit(self, context: Context) -> Context:
        """This tick's context as a child has it: what it publishes goes to its parent first."""
        own = self.__context
        if own is None:
            return context
        own.time, own.pose, own.in_control = context.time, context.pose, context.in_control
        own.distance, own.turn = context.distance, context.turn
        self.__outer = context
        return own

    def __tell(self, event: Event) -> bool:
        parent, outer = self.__parent, self.__outer
        assert parent is not None
        assert outer is not None
        parent.on_child_event(self, event, outer)
        return True


def check_declarations(cls: type[Behavior]) -> None:
    """Raises BehaviorContractError, naming class and lack, if the class does not declare what it must."""
    check(cls, Behavior)
