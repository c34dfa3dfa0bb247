"""Steps that consist of others: at once, repeated, with a limit of time, tried, for each node."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from ..errors import StepFailedError
from ..listener import Outcome
from .forms import Count, Form, Seconds
from .step import UNKNOWN, Body, Inner, Plan, Run, Script, Step, Task, done, is_body, limited

if TYPE_CHECKING:
    from ...files.yaml_nodes import Entry

_SAMPLE = [0, 1, 2]
"""The nodes of a map that nobody knows yet."""


class _Composed(Step):
    """What they share: in a dry run a line in words, then what is inside."""

    __slots__ = ()
    body: Any
    keys: ClassVar = {"steps": "body"}

    @property
    def line(self) -> str:
        """In words."""
        return self.words

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """What is inside."""
        return plan.body(self.body, depth)


@dataclass(frozen=True, slots=True, init=False)
class _AtOnce(_Composed):
    """Several bodies at once. first_wins: whether a success ends it, or else a failure."""

    first_wins: ClassVar[bool]
    bodies: Annotated[tuple[Body, ...], Form("at least one step", is_body)]

    def __init__(self, *bodies: Body) -> None:
        """What is done at once."""
        object.__setattr__(self, "bodies", bodies)
        self.__post_init__()

    def begin(self, run: Run, path: str) -> Task:
        """Begins all."""
        running = {index: run.begin(body, f"{path}.{index + 1}") for index, body in enumerate(self.bodies)}
        ended: dict[int, Outcome] = {}

        def cancel() -> None:
            rest = list(running.values())
            running.clear()
            for task in rest:
                task.cancel()

        def poll(time: float) -> Outcome | None:
            for index, task in list(running.items()):
                outcome = task.poll(time)
                if outcome is None:
                    continue
                del running[index]
                ended[index] = outcome
                if outcome.succeeded is self.first_wins:
                    cancel()
                    return Outcome(True, (index, outcome.result)) if self.first_wins else outcome
            return None if running else self._all(ended)

        return Task(poll, cancel)

    def _all(self, ended: dict[int, Outcome]) -> Outcome:
        if self.first_wins:
            return Outcome(False, reason="; ".join(each.reason for each in ended.values()))
        return Outcome(True, [ended[index].result for index in sorted(ended)])

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """All of them, one after the other."""
        return [plan.body(body, depth) for body in self.bodies]

    @classmethod
    def read(cls, entry: Entry, body: Callable[[Entry], Body]) -> Step:
        """From a list."""
        bodies = body(entry)
        return cls(*(bodies if isinstance(bodies, tuple) else (bodies,)))


class Race(_AtOnce):
    """All at once; the first that succeeds ends it and cancels the others. Result: (index, its result).

    Fails when all have failed.
    """

    __slots__ = ()
    says, word, first_wins = "race: the first that succeeds", "race", True

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """The first one wins."""
        return 0, super().rehearse(plan, depth)[0]


class Together(_AtOnce):
    """All at once, until all have succeeded. Result: their results. The first failure cancels the rest."""

    __slots__ = ()
    says, word, first_wins = "all at once", "together", False


@dataclass(frozen=True, slots=True)
class Within(_Composed):
    """Do something in at most so many simulated seconds, else fail."""

    seconds: Seconds
    body: Inner
    says, word = "within {seconds:g} s", "within"

    def begin(self, run: Run, path: str) -> Task:
        """Begins it, and its time."""
        end = run.agent.context.time + self.seconds
        return limited(run.begin(self.body, f"{path}.1"), end, f"not done within {self.seconds:g} s")


@dataclass(frozen=True, slots=True)
class Repeat(_Composed):
    """Do something several times; None: until it fails or is cancelled. Result: the last one's."""

    body: Inner
    times: Count | None = None
    word = "repeat"

    @property
    def words(self) -> str:
        """In words."""
        return "forever" if self.times is None else f"{self.times} times"

    def begin(self, run: Run, path: str) -> Task:
        """Begins the first time."""
        return run.follow(self._script, path)

    def _script(self) -> Script:
        result, count = None, 0
        while self.times is None or count < self.times:
            result = yield self.body
            count += 1
        return result


@dataclass(frozen=True, slots=True)
class OnFailure(_Composed):
    """Do `body`; if it fails try it `retries` times more, then do `otherwise` (None: fail)."""

    body: Inner
    otherwise: Inner | None = None
    retries: Count = 0
    word = "on_failure"
    keys: ClassVar = {"do": "body"}

    @property
    def words(self) -> str:
        """In words."""
        return "try" if not self.retries else f"try, at most {self.retries + 1} times"

    def begin(self, run: Run, path: str) -> Task:
        """Begins the first attempt."""
        return run.follow(self._script, path)

    def _script(self) -> Script:
        last: StepFailedError | None = None
        for _ in range(self.retries + 1):
            try:
                return (yield self.body)
            except StepFailedError as failed:
                last = failed
        if self.otherwise is None and last is not None:
            raise last
        return (yield self.otherwise)

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """What is tried, then what is done otherwise."""
        result = plan.body(self.body, depth)
        if self.otherwise is not None:
            plan.note("otherwise", depth - 1)
            plan.body(self.otherwise, depth)
        return result


@dataclass(frozen=True, slots=True)
class As(_Composed):
    """Do something with another of the world's robots; 0 is the first."""

    robot: Count
    body: Inner
    says, word = "with robot {robot}", "as"

    def begin(self, run: Run, path: str) -> Task:
        """Begins it there."""
        return run.on_robot(self.robot).begin(self.body, f"{path}.1")


@dataclass(frozen=True, slots=True)
class Nodes(Step):
    """Result: the numbers of the map's nodes, sorted."""

    says, word = "list the nodes", "nodes"

    def begin(self, run: Run, path: str) -> Task:
        """Is done at once."""
        return done(run.site.nodes())

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """The nodes, some where nobody knows them."""
        return list(_SAMPLE if plan.nodes is None else plan.nodes)


@dataclass(frozen=True, slots=True)
class ForEachNode(_Composed):
    """Do something for each node of the map: `body` is called with its number and gives a step."""

    body: Annotated[Callable[[int], Body], Form("a function of a node's number that gives a step", callable)]
    says, word = "for each node", "for_each_node"

    def begin(self, run: Run, path: str) -> Task:
        """Begins with the first node."""
        return run.follow(self._script, path)

    def _script(self) -> Script:
        for node in (yield Nodes()):
            yield self.body(node)

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """What is done for each node."""
        for node in Nodes().rehearse(plan, depth):
            plan.body(self.body(node), depth)
        return UNKNOWN

    @classmethod
    def read(cls, entry: Entry, body: Callable[[Entry], Body]) -> Step:
        """From steps in which `$node` stands for the node's number."""

        def steps(node: int) -> Body:
            return body(entry.substituted("$node", str(node)))

        steps(0)  # so that a fault is found now, not at the first node
        return cls(steps)
