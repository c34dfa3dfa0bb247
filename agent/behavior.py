"""The behavior contract: a state machine that, once a tick, may propose how to drive.

A behavior is a subclass of `Behavior`. It declares

- `name`: how missions, configuration and events call it;
- `priority`: higher wins under the default mediator (the built-in ones: obstacle avoidance 50, local
  exploration and local navigation 40, position correction 30, go-to-node 20, wall following 10);
- `States`: an Enum; `initial`: the state after `reset`; `transitions`: the table, as data;
- `Config`: a frozen dataclass of settings with defaults, units in its docstring;

and implements `propose`. Everything else has a default. A behavior never blocks, never sleeps, never asks
the clock: the time is `context.time`, randomness `context.rng`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from enum import Enum
from typing import Any, ClassVar

import numpy as np
from transitions import Machine

from ..world.robot import Image, Percept, Pose, RobotGeometry, WheelCommand
from .errors import AgentError, BehaviorContractError, ConfigError
from .events import Event, Subscription


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
    """One row of a behavior's table: `trigger` leads from any of `sources` to `target`."""

    trigger: str
    sources: Enum | tuple[Enum, ...]
    target: Enum


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


class _StateHolder:
    """The model of the state machine: keeps the triggers' names apart from the behavior's own methods."""

    state: Enum


class Behavior(ABC):
    """Base class of all behaviors. See the module's text for what a subclass declares."""

    name: ClassVar[str] = ""
    priority: ClassVar[int] = 0
    States: ClassVar[type[Enum]]
    initial: ClassVar[Enum]
    transitions: ClassVar[tuple[Transition, ...]] = ()
    Config: ClassVar[type[Any]] = NoConfig
    restarts: ClassVar[bool] = False
    """Whether the agent starts it again by itself after a fault, until it is disabled: for reflexes."""
    slow_start: ClassVar[bool] = False
    """Whether its start and stop are outside the time budget, as where a process has to begin first."""
    example_goal: ClassVar[Any] = None
    """A goal that `on_start` takes, for `tolman plugins check`; None for a behavior that needs none."""

    def __init__(self, config: Any = None, **settings: Any) -> None:
        """`config`: an instance of `Config`; or give its fields by keyword.

        Raises: BehaviorContractError if the class lacks a declaration, ConfigError for a wrong setting.
        """
        check_declarations(type(self))
        self.config: Any = self._configured(config, settings)
        self._holder = _StateHolder()
        self._machine = Machine(
            model=self._holder,
            states=type(self).States,
            initial=type(self).initial,
            transitions=[
                {"trigger": row.trigger, "source": _sources(row), "dest": row.target}
                for row in type(self).transitions
            ],
            auto_transitions=False,
            queued=True,
        )
        self._allowed = {(source, row.trigger) for row in type(self).transitions for source in _sources(row)}
        self.finished = False
        self.succeeded = False
        self.reason = ""
        self.result: Any = None
        self.on_reset()

    # --- to override ---------------------------------------------------------------------------------

    @abstractmethod
    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """Returns how to drive, or None if it has nothing to say. Called once a tick while active."""

    def on_start(self, goal: Any, context: Context) -> None:  # noqa: B027
        """Takes a goal. Called once, before the first `propose`, in the initial state."""

    def on_reset(self) -> None:  # noqa: B027
        """Forgets everything but the configuration. Called by the constructor and before each start."""

    def on_stop(self, context: Context) -> None:  # noqa: B027
        """Lets go of what it holds. Called once when it finished, was stopped or broke the contract."""

    # --- to use --------------------------------------------------------------------------------------

    @property
    def state(self) -> Any:
        """The state it is in, a member of `States`."""
        return self._holder.state

    def fire(self, trigger: str) -> None:
        """Takes the transition of that name. Raises: BehaviorContractError if there is none from here."""
        if (self._holder.state, trigger) not in self._allowed:
            known = sorted(name for source, name in self._allowed if source is self._holder.state)
            raise BehaviorContractError(
                f"{self.name}: no transition {trigger!r} from state {self.state.name}; known here: "
                f"{', '.join(known) or 'none'}"
            )
        self._machine.events[trigger].trigger(self._holder)

    def finish(self, succeeded: bool, reason: str = "", result: Any = None) -> None:
        """Says that the goal is reached or given up; the agent publishes `BehaviorFinished` with it."""
        self.finished, self.succeeded, self.reason, self.result = True, succeeded, reason, result

    def reset(self) -> None:
        """Back to the initial state, as if new."""
        self._machine.set_state(type(self).initial, self._holder)
        self.finished = self.succeeded = False
        self.reason, self.result = "", None
        self.on_reset()

    def _configured(self, config: Any, settings: dict[str, Any]) -> Any:
        cls = type(self).Config
        if config is not None:
            if not isinstance(config, cls):
                raise ConfigError(
                    f"{self.name}: config must be a {cls.__name__}, not {type(config).__name__}"
                )
            return config
        known = {f.name: f.default for f in fields(cls)}
        for key, value in settings.items():
            if key not in known:
                near = get_close_matches(key, known, n=1)
                hint = f"did you mean {near[0]!r}? " if near else ""
                raise ConfigError(
                    f"{self.name}: unknown setting {key!r}; {hint}known: {', '.join(sorted(known)) or 'none'}"
                )
            _check_setting(f"{self.name}: {key}", value, known[key])
        return cls(**settings)


def _check_setting(what: str, value: Any, default: Any) -> None:
    """Raises ConfigError if `value` is not of the kind of the setting's default."""
    if isinstance(default, bool):
        fits, kind = isinstance(value, bool), "true or false"
    elif isinstance(default, int):
        fits, kind = isinstance(value, int) and not isinstance(value, bool), "a whole number"
    elif isinstance(default, float):
        number = isinstance(value, int | float) and not isinstance(value, bool)
        fits, kind = number and math.isfinite(value), "a finite number"
    elif isinstance(default, str):
        fits, kind = isinstance(value, str), "a text"
    else:
        return
    if not fits:
        raise ConfigError(f"{what} must be {kind}, not {value!r}")


def _sources(row: Transition) -> list[Enum]:
    return list(row.sources) if isinstance(row.sources, tuple) else [row.sources]


def check_declarations(cls: type[Behavior]) -> None:
    """Raises BehaviorContractError, naming class and lack, if the class does not declare what it must."""
    if not cls.name:
        raise BehaviorContractError(f"{cls.__name__}: declare a `name`, such as name = 'wall-following'")
    states = getattr(cls, "States", None)
    if not (isinstance(states, type) and issubclass(states, Enum) and len(states)):
        raise BehaviorContractError(f"{cls.name}: declare `States`, an Enum with at least one member")
    initial = getattr(cls, "initial", None)
    if not isinstance(initial, states):
        raise BehaviorContractError(f"{cls.name}: `initial` must be a member of States, not {initial!r}")
    for row in cls.transitions:
        for state in (*_sources(row), row.target):
            if not isinstance(state, states):
                raise BehaviorContractError(
                    f"{cls.name}: transition {row.trigger!r} names {state!r}, not in States"
                )
