"""The steps of a mission: plain data that a mission yields, readable as a sentence.

A mission is a generator function. It yields a step, is resumed with the step's result when it is done, and
gets `StepFailedError` raised at the `yield` when it failed. Where a step takes others, each may be a step, a
tuple of steps (one after the other), or a generator function.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ..events import Event


@dataclass(frozen=True, slots=True)
class Step:
    """Base of all steps."""


Body: TypeAlias = Step | tuple[Any, ...] | Callable[[], Generator[Any, Any, Any]]
"""What can stand where a step is wanted."""


@dataclass(frozen=True, slots=True)
class Explore(Step):
    """Map the surroundings along the wall on `side`. Result: why it ended, such as "loop closed".

    wait: False starts it and goes on at once, to wait for events by `Until`. islands: whether to look for
    obstacles that stand free, once the loop is closed.
    """

    side: str = "right"
    strategy: str = "alternate"
    max_nodes: int | None = None
    wait: bool = True
    islands: bool = False


@dataclass(frozen=True, slots=True)
class GoTo(Step):
    """Drive to a node of the map. Result: the node."""

    node: int | str


@dataclass(frozen=True, slots=True)
class Save(Step):
    """Save the map to a file. Result: the path."""

    path: str


@dataclass(frozen=True, slots=True)
class Load(Step):
    """Take over the map in a file; the robot is taken to stand where it was when that was saved."""

    path: str


@dataclass(frozen=True, slots=True)
class Place(Step):
    """Have somebody put the robot at a node, in its transition pose, as a simulation can. Result: it."""

    node: int | str


@dataclass(frozen=True, slots=True)
class Nodes(Step):
    """Result: the numbers of the map's nodes, sorted."""


@dataclass(frozen=True, slots=True)
class Look(Step):
    """Take a camera image, standing still. Result: (height, width) luminance in [0, 1]."""


@dataclass(frozen=True, slots=True)
class Do(Step):
    """Start a behavior with a goal and wait until it has finished. Result: the behavior's."""

    behavior: str
    goal: Any = None


@dataclass(frozen=True, slots=True)
class Until(Step):
    """Wait for an event of a type. Result: the event. Fails after `timeout` simulated seconds.

    where: fields that must have these values.
    """

    event: type[Event]
    timeout: float | None = None
    where: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Wait(Step):
    """Let simulated seconds pass; whatever is active goes on."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Say(Step):
    """Tell whoever follows the mission."""

    text: str


@dataclass(frozen=True, slots=True)
class Fail(Step):
    """Fail, with a reason."""

    reason: str


@dataclass(frozen=True, slots=True, init=False)
class Race(Step):
    """All at once; the first that succeeds ends it and cancels the others. Result: (index, its result).

    Fails when all have failed.
    """

    bodies: tuple[Body, ...]

    def __init__(self, *bodies: Body) -> None:
        """The contenders."""
        object.__setattr__(self, "bodies", bodies)


@dataclass(frozen=True, slots=True, init=False)
class Together(Step):
    """All at once, until all have succeeded. Result: their results. The first failure cancels the rest."""

    bodies: tuple[Body, ...]

    def __init__(self, *bodies: Body) -> None:
        """What is done at once."""
        object.__setattr__(self, "bodies", bodies)


@dataclass(frozen=True, slots=True)
class Within(Step):
    """Do something in at most so many simulated seconds, else fail."""

    seconds: float
    body: Body


@dataclass(frozen=True, slots=True)
class Repeat(Step):
    """Do something several times; None: until it fails or is cancelled. Result: the last one's."""

    body: Body
    times: int | None = None


@dataclass(frozen=True, slots=True)
class OnFailure(Step):
    """Do `body`; if it fails try it `retries` times more, then do `otherwise` (None: fail)."""

    body: Body
    otherwise: Body | None = None
    retries: int = 0


@dataclass(frozen=True, slots=True)
class As(Step):
    """Do something with another of the world's robots; 0 is the first."""

    robot: int
    body: Body


@dataclass(frozen=True, slots=True)
class ForEachNode(Step):
    """Do something for each node of the map: `body` is called with its number and gives a step."""

    body: Callable[[int], Body]


def describe(body: Any) -> str:
    """A step as one readable line: `GoTo(node=5)`, without what is at its default."""
    if isinstance(body, Race | Together):
        return f"{type(body).__name__}({', '.join(describe(each) for each in body.bodies)})"
    if isinstance(body, tuple):
        return f"({', '.join(describe(each) for each in body)})"
    if isinstance(body, type):
        return body.__name__
    if isinstance(body, Step):
        return f"{type(body).__name__}({', '.join(_arguments(body))})"
    if callable(body):
        return f"{getattr(body, '__name__', type(body).__name__)}()"
    return repr(body)


def _arguments(step: Step) -> list[str]:
    shown = []
    for name, spec in type(step).__dataclass_fields__.items():
        value = getattr(step, name)
        if value == spec.default or (value == {} and name == "where"):
            continue
        nested = isinstance(value, Step | tuple | type) or callable(value)
        shown.append(f"{name}={describe(value) if nested else repr(value)}")
    return shown
