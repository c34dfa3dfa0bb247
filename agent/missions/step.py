"""What a step is: one class with its data, its text, what it does, its YAML form and its dry run.

A new step is a frozen dataclass derived from `Step` that says in `begin` what it does; the rest has defaults
that follow from its fields. A Python mission can yield it as it is; for YAML it needs a `word`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, TypeAlias

from ...files.messages import quoted
from ..errors import MissionError
from ..listener import Outcome
from .forms import Form, forms_of, values_of

if TYPE_CHECKING:
    from ...files.yaml_nodes import Entry
    from ..agent import Agent

MAX_DEPTH = 50
"""How many steps may be within one another."""
Script: TypeAlias = Generator[Any, Any, Any]


@dataclass(frozen=True, slots=True)
class Task:
    """A step under way.

    poll: called once a tick with the simulated time (s); gives the outcome when there is one. cancel: ends it
    before its time and stops what it started; called at most once, never after the outcome.
    """

    poll: Callable[[float], Outcome | None]
    cancel: Callable[[], None] = lambda: None


def done(result: Any = None) -> Task:
    """The task of what was done at once."""
    return Task(lambda time: Outcome(True, result))


def limited(task: Task, end: float, reason: str) -> Task:
    """The task, which fails for this reason unless it has ended at the simulated time `end` (s)."""

    def poll(time: float) -> Outcome | None:
        outcome = task.poll(time)
        if outcome is None and time >= end:
            task.cancel()
            return Outcome(False, reason=reason)
        return outcome

    return Task(poll, task.cancel)


class Job(Protocol):
    """A drive under way, as a `Site` gives it: a mapping or a trip."""

    @property
    def outcome(self) -> Outcome | None:
        """None while it is under way."""

    def cancel(self) -> None:
        """Stops what it started."""


class Site(Protocol):
    """What a mission needs of the session it runs in: somebody who maps, navigates and keeps files."""

    def explore(self, side: str, strategy: str, max_nodes: int | None, islands: bool) -> Job:
        """Begins mapping. The fields are those of the step `Explore`."""

    def go_to(self, node: int | str) -> Job:
        """Begins a trip. Raises: LookupError or ValueError if there is no such node."""

    def save(self, path: str) -> None:
        """Saves the map."""

    def load(self, path: str) -> None:
        """Takes over a saved map."""

    def nodes(self) -> list[int]:
        """The map's nodes, sorted."""

    def place(self, node: int | str) -> int:
        """Puts the robot at a node and returns its number. Raises: MissionError where nobody can."""

    def robot(self, index: int) -> tuple[Agent, Site]:
        """Another robot of the same world, and what serves it. Raises: LookupError if there is none."""


class Run(Protocol):
    """What a step is given when it begins: the robot it works with, and how to begin further steps."""

    @property
    def agent(self) -> Agent:
        """The robot's agent."""

    @property
    def site(self) -> Site:
        """What serves this robot."""

    def begin(self, body: Any, path: str) -> Task:
        """Begins another body. path: its place in the mission, as 3.1."""

    def follow(self, script: Callable[[], Script], path: str) -> Task:
        """Begins a script that yields bodies. path: of the step that has it."""

    def say(self, text: str) -> None:
        """Tells a text to whoever follows the mission."""

    def on_robot(self, index: int) -> Run:
        """The same with another robot. Raises: LookupError if there is none."""


class Step:
    """Base of all steps. Raises: MissionError for a value that a field does not take.

    says: the step for people, with its fields in braces. word: what YAML calls it. single: the field that
    gets a YAML value which is no mapping. keys: fields by their names in YAML, where these are others.
    """

    __slots__ = ()
    says: ClassVar[str] = ""
    word: ClassVar[str] = ""
    single: ClassVar[str] = ""
    keys: ClassVar[Mapping[str, str]] = {}

    def __post_init__(self) -> None:
        """Checks the fields."""
        for name, (form, optional) in forms_of(type(self)).items():  # type: ignore[arg-type]
            value = getattr(self, name)
            if not (isinstance(value, Unknown) or (value is None and optional) or form.fits(value)):
                raise MissionError(f"{type(self).__name__}: {name}: give {form.says}, not {quoted(value)}")
        self.check()

    def check(self) -> None:
        """Checks what concerns more than one field. Raises: MissionError."""

    def begin(self, run: Run, path: str) -> Task:
        """Starts it. path: its place in the mission. What this raises is the reason why it failed."""
        raise NotImplementedError

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """Tells a dry run what is inside and what would go wrong; gives what would come of it."""
        return UNKNOWN

    @property
    def words(self) -> str:
        """The step in a few words, for people."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
        return self.says.format(**values) or describe(self)

    @property
    def line(self) -> str:
        """The step's line in a dry run."""
        return describe(self)

    @classmethod
    def read(cls, entry: Entry, body: Callable[[Entry], Body]) -> Step:
        """The step that a YAML value describes. body: makes the steps within it. Raises: MissionError."""
        values = values_of(cls, entry, body)
        try:
            return cls(**values)
        except MissionError as fault:
            raise entry.error(str(fault)) from None


Body: TypeAlias = Step | tuple[Any, ...] | Callable[[], Script]
"""What can stand where a step is wanted: a step, a tuple of them, a generator function."""


def is_body(value: Any) -> bool:
    """Whether this can stand where a step is wanted."""
    if isinstance(value, tuple):
        return bool(value) and all(is_body(item) for item in value)
    return isinstance(value, Step | Unknown) or (callable(value) and not isinstance(value, type))


def script_of(body: Any) -> Callable[[], Script] | None:
    """The generator function that a body is, or that a tuple of bodies stands for; None for all else."""
    if isinstance(body, tuple):
        return lambda: in_order(body)
    return body if callable(body) and not isinstance(body, Step | type) else None


def in_order(bodies: tuple[Any, ...]) -> Script:
    """One after the other; the last one's result."""
    result = None
    for body in bodies:
        result = yield body
    return result


Inner = Annotated[Body, Form("a step, a tuple of steps or a generator function", is_body, steps=True)]


def describe(body: Any) -> str:
    """A body as the code that makes it: `GoTo(node=5)`, without defaults. Journals hold this."""
    if isinstance(body, tuple):
        return f"({', '.join(describe(each) for each in body)})"
    if isinstance(body, type):
        return body.__name__
    if isinstance(body, Step):
        return f"{type(body).__name__}({', '.join(_arguments(body))})"
    if callable(body):
        return f"{getattr(body, '__name__', type(body).__name__)}()"
    return repr(body)


def _arguments(step: Step) -> Iterator[str]:
    for spec in fields(step):  # type: ignore[arg-type]
        value = getattr(step, spec.name)
        if value == spec.default or (spec.default_factory is not MISSING and value == spec.default_factory()):
            continue
        nested = isinstance(value, Step | tuple | type) or callable(value)
        text = describe(value) if nested else repr(value)
        yield text[1:-1] if spec.name == "bodies" else f"{spec.name}={text}"


def in_words(body: Any) -> str:
    """A body in a few words, for people."""
    if isinstance(body, tuple):
        return f"{len(body)} steps"
    return body.words if isinstance(body, Step) else describe(body)


class Unknown:
    """Stands in a dry run for a result that nobody knows yet: has every attribute, is equal to nothing."""

    def __getattr__(self, name: str) -> Unknown:
        """Nor is it known what its attributes are."""
        return self

    def __repr__(self) -> str:
        """A question mark."""
        return "?"


UNKNOWN = Unknown()


@dataclass(slots=True)
class Plan:
    """A dry run, as far as it is. lines: the steps, indented. problems: what would go wrong.

    nodes: of the map at this point, None: unknown. behaviors: the loaded ones, None: any. limit: most lines.
    within: how many bodies it is in.
    """

    nodes: Sequence[int] | None = None
    behaviors: Collection[str] | None = None
    limit: int = 500
    within: int = 0
    lines: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def body(self, body: Any, depth: int) -> Any:
        """Notes a body and gives what would come of it."""
        if len(self.lines) >= self.limit:
            return UNKNOWN
        if self.within > MAX_DEPTH:
            raise MissionError(f"more than {MAX_DEPTH} steps within one another")
        self.within += 1
        result = self._inside(body, depth)
        self.within -= 1
        return result

    def _inside(self, body: Any, depth: int) -> Any:
        script = script_of(body)
        if script is not None:
            return self._script(script(), depth)
        if not isinstance(body, Step):
            self.problems.append(f"a mission yields steps such as GoTo(5), not {quoted(body)}")
            return UNKNOWN
        self.note(body.line, depth)
        return body.rehearse(self, depth + 1)

    def note(self, text: str, depth: int) -> None:
        """Adds a line."""
        self.lines.append("  " * depth + text)

    def _script(self, script: Script, depth: int) -> Any:
        result = None
        try:
            while len(self.lines) < self.limit:
                result = self.body(script.send(result), depth)
            script.close()
        except StopIteration as stop:
            return stop.value
        return UNKNOWN
