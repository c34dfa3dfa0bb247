"""Dry run: what a mission would do, and what is wrong with it as far as can be told without a robot."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..containment import describe as describe_fault
from .mission import Mission
from .runtime import in_order
from .steps import (
    As,
    Do,
    Explore,
    ForEachNode,
    GoTo,
    Load,
    Look,
    Nodes,
    OnFailure,
    Race,
    Repeat,
    Step,
    Together,
    Within,
    describe,
)

_LIMIT = 500
_SAMPLE = (0, 1, 2)
"""The nodes of a map that nobody knows yet."""


class _Something:
    """Stands for a result nobody can know in advance: has every attribute, is equal to nothing."""

    def __getattr__(self, name: str) -> _Something:
        return self

    def __str__(self) -> str:
        return "?"

    __repr__ = __str__


@dataclass(slots=True)
class Plan:
    """What a dry run found. lines: the steps, indented. problems: what would go wrong."""

    lines: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def dry_run(
    mission: Mission, nodes: Sequence[int] | None = None, behaviors: Collection[str] | None = None
) -> Plan:
    """Goes through the mission as if every step succeeded.

    nodes: those of the map it will be run with; None: unknown. behaviors: the loaded ones; None: any.
    """
    walk = _Walk(nodes, behaviors)
    walk.script(mission.body, 0)
    return walk.plan


class _Walk:
    def __init__(self, nodes: Sequence[int] | None, behaviors: Collection[str] | None) -> None:
        self.plan = Plan()
        self._nodes, self._behaviors = nodes, behaviors

    def script(self, body: Callable[[], Generator[Any, Any, Any]], depth: int) -> Any:
        generator = body()
        try:
            step = next(generator)
            while len(self.plan.lines) < _LIMIT:
                step = generator.send(self.body(step, depth))
            self.plan.lines.append(f"... (only the first {_LIMIT} steps are shown)")
            generator.close()
        except StopIteration as stop:
            return stop.value
        except Exception as fault:
            self.plan.problems.append(f"the script raised {describe_fault(fault)}")
        return _Something()

    def body(self, body: Any, depth: int) -> Any:
        """Notes a body and gives what would come of it."""
        if isinstance(body, tuple):
            return self.script(lambda: in_order(body), depth)
        if callable(body) and not isinstance(body, Step | type):
            return self.script(body, depth)
        if not isinstance(body, Step):
            self.plan.problems.append(f"a mission yields steps such as GoTo(5), not {body!r}")
            return _Something()
        self._note(self._headline(body), depth)
        return self._inside(body, depth + 1)

    def _headline(self, step: Step) -> str:
        if isinstance(step, Repeat):
            return "forever" if step.times is None else f"{step.times} times"
        if isinstance(step, Within):
            return f"within {step.seconds:g} s"
        if isinstance(step, As):
            return f"with robot {step.robot}"
        if isinstance(step, Race):
            return "race: the first that succeeds"
        if isinstance(step, Together):
            return "all at once"
        if isinstance(step, OnFailure):
            return "try" if not step.retries else f"try, at most {step.retries + 1} times"
        if isinstance(step, ForEachNode):
            return "for each node"
        return describe(step)

    def _inside(self, step: Step, depth: int) -> Any:
        if isinstance(step, Race | Together):
            results = [self.body(body, depth) for body in step.bodies]
            return (0, results[0]) if isinstance(step, Race) and results else results
        if isinstance(step, Repeat | Within | As):
            return self.body(step.body, depth)
        if isinstance(step, OnFailure):
            result = self.body(step.body, depth)
            if step.otherwise is not None:
                self._note("otherwise", depth - 1)
                self.body(step.otherwise, depth)
            return result
        if isinstance(step, ForEachNode):
            for node in _SAMPLE if self._nodes is None else self._nodes:
                self.body(step.body(node), depth)
            return _Something()
        return self._single(step)

    def _single(self, step: Step) -> Any:
        if isinstance(step, Nodes):
            return list(_SAMPLE if self._nodes is None else self._nodes)
        if isinstance(step, Look):
            return np.zeros((16, 16), dtype=np.float32)
        if isinstance(step, Explore | Load):
            self._nodes = None  # from here on nobody knows what the map will hold
        elif isinstance(step, GoTo) and self._nodes is not None and isinstance(step.node, int):
            if step.node not in self._nodes:
                self.plan.problems.append(f"{describe(step)}: the map has no node {step.node}")
            return step.node
        elif isinstance(step, Do) and self._behaviors is not None and step.behavior not in self._behaviors:
            self.plan.problems.append(f"{describe(step)}: there is no such behavior")
        return _Something()

    def _note(self, text: str, depth: int) -> None:
        self.plan.lines.append("  " * depth + text)
