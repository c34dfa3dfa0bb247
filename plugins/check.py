"""The conformance suite: what `tolman plugins check` runs on a behavior, and what to fix."""

from __future__ import annotations

import contextlib
import inspect
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..agent.agent import Agent
from ..agent.behavior import Behavior, check_declarations
from ..agent.codec import decode, dumps
from ..agent.containment import check_proposal, describe
from ..agent.errors import GoalError
from ..agent.events import BehaviorFaulted, Event
from ..agent.fields import needs_values
from ..agent.handle import Limits
from ..files.interrupts import ends_run
from ..world.robot import EPUCK, Percept
from .diagram import edges
from .trial import FAR, ScriptedRobot, Trial, percept

SLOW = 500e-6
"""Seconds that the median `propose` may take."""
_SIMULATORS = ("dartpy", "embreex", "matplotlib")
_LOADS = "importing it loads {}: import only tolman.world.robot of the world"


@dataclass(frozen=True, slots=True)
class Finding:
    """One check: whether it passed, and if not what to fix."""

    check: str
    passed: bool
    fix: str = ""


@dataclass(frozen=True, slots=True)
class Report:
    """What the suite found about one plugin."""

    name: str
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(finding.passed for finding in self.findings)

    def text(self) -> str:
        """One line a check."""
        lines = [f"{self.name}: {'conforms' if self.passed else 'does not conform'}"]
        for finding in self.findings:
            lines.append(
                f"  {'ok  ' if finding.passed else 'FIX '} {finding.check}"
                + (f": {finding.fix}" if finding.fix else "")
            )
        return "\n".join(lines)


def check_behavior(cls: type[Behavior], goal: Any = None, *, ticks: int = 300, fresh: bool = False) -> Report:
    """Runs every check on the class and never raises for its faults.

    goal: None takes the class's `example`, or the defaults of its `Goal`. fresh: whether this process has
    loaded nothing but the plugin.
    """
    if goal is None:
        goal = cls.example
    checks: tuple[tuple[str, Callable[[], Iterator[str]]], ...] = (
        ("declarations", lambda: _declarations(cls)),
        ("documentation", lambda: _documentation(cls)),
        ("configuration", lambda: _configuration(cls)),
        ("goal", lambda: _goal(cls, goal)),
        ("states", lambda: _states(cls)),
        ("sane proposals", lambda: _proposals(cls, goal, ticks)),
        ("determinism", lambda: _determinism(cls, goal, ticks)),
        ("reset", lambda: _reset(cls, goal, ticks)),
        ("limits", lambda: _limits(cls, goal, ticks)),
        ("speed", lambda: _speed(cls, goal, ticks)),
        ("no simulator", lambda: _no_simulator_here() if fresh else _no_simulator(cls)),
    )
    return Report(cls.name or cls.__name__, tuple(_run(name, check) for name, check in checks))


def _run(name: str, check: Callable[[], Iterator[str]]) -> Finding:
    try:
        problem = next(check(), None)
    except BaseException as fault:
        if ends_run(fault):
            raise
        problem = describe(fault)
    return Finding(name, problem is None, problem or "")


def percepts(ticks: int) -> list[Percept]:
    """A fixed run through all that can be sensed: plain, walls at any side, corners, corridors, noise."""
    rng = np.random.default_rng(1)
    run = []
    for tick in range(ticks):
        gaps = np.where(rng.random(4) < 0.5, rng.uniform(0.0, 0.08, 4), FAR)
        if (tick // 25) % 4 == 0:
            gaps = np.full(4, FAR)
        front, left, rear, right = (float(gap) for gap in gaps)
        run.append(percept(front=front, left=left, rear=rear, right=right, tick=tick))
    return run


def _declarations(cls: type[Behavior]) -> Iterator[str]:
    check_declarations(cls)
    if cls.name != cls.name.lower() or any(c in cls.name for c in " _/"):
        yield f"name = {cls.name!r}: write it in lower case with dashes, as in 'wall-following'"


def _documentation(cls: type[Behavior]) -> Iterator[str]:
    if not inspect.getdoc(cls) or cls.__doc__ is None:
        yield f"class {cls.__name__} has no docstring: say in one line what the robot does"
    if cls.States.__doc__ in (None, "An enumeration.") or not cls.States.__doc__:
        yield "States has no docstring: say what each state means"
    yield from _undescribed(cls.Config, "setting")
    if cls.Goal is not None:
        yield from _undescribed(cls.Goal, "field")
    for name in (state.name.lower() for state in cls.States):
        for method in (name, f"on_enter_{name}"):
            if hasattr(cls, method) and not inspect.getdoc(getattr(cls, method)):
                yield f"the method {method!r} has no docstring: say in one line what the robot does"


def _undescribed(declared: type[Any], word: str) -> Iterator[str]:
    described = declared.__doc__ or ""
    for each in fields(declared):
        plural = f"{each.name.rpartition('_')[2]}s"  # `speeds: steps/s` tells of several
        if each.name not in described and plural not in described:
            yield f"the {word} {each.name!r} is not in the docstring of {declared.__name__}: give its unit"


def _configuration(cls: type[Behavior]) -> Iterator[str]:
    config = cls.Config
    if not is_dataclass(config) or not config.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        yield f"{config.__name__} must be a frozen dataclass: @dataclass(frozen=True, slots=True)"
    config()  # every setting needs a default


def _goal(cls: type[Behavior], goal: Any) -> Iterator[str]:
    """Goals fit, survive being recorded, and what is no goal is refused."""
    if cls.Goal is not None and goal is None and needs_values(cls.Goal):
        yield f"{cls.Goal.__name__} has fields without defaults: declare `example`, a goal to check with"
        return
    fitted = cls().fitted_goal(goal)
    if cls.Goal is None:
        return
    if cls().fitted_goal(decode(json.loads(dumps(fitted)))) != fitted:
        yield f"a recorded {cls.Goal.__name__} does not come back as it was: use plain types in its fields"
    with contextlib.suppress(GoalError):
        cls().fitted_goal(object())
        yield "it takes anything for a goal: do not override `fitted_goal`"


def _states(cls: type[Behavior]) -> Iterator[str]:
    reached, table = {cls.initial}, edges(cls)
    while more := {target for source, target in table if source in reached} - reached:
        reached |= more
    if lost := [state.name for state in cls.States if state not in reached]:
        yield f"no transition leads to {', '.join(lost)}: add one to the table or leave the state out"


def _proposals(cls: type[Behavior], goal: Any, ticks: int) -> Iterator[str]:
    trial = Trial(cls(), goal=goal)
    for tick, sensed in enumerate(percepts(ticks)):
        proposal = trial.step(sensed)
        if proposal is None:
            continue
        try:
            check_proposal(proposal, 10.0 * EPUCK.max_speed)
        except (TypeError, ValueError) as fault:
            yield f"in tick {tick}: {fault}"
        if not proposal.reason:
            yield f"in tick {tick} the proposal has no reason: say in a few words why it drives so"


def _trace(behavior: Behavior, goal: Any, ticks: int) -> Sequence[Any]:
    trial = Trial(behavior, goal=goal)
    trial.run(percepts(ticks))
    return [list(trial.proposals), list(trial.states), [repr(event) for event in trial.events]]


def _determinism(cls: type[Behavior], goal: Any, ticks: int) -> Iterator[str]:
    if _trace(cls(), goal, ticks) != _trace(cls(), goal, ticks):
        yield (
            "two runs on the same percepts differ: take randomness from context.rng, time from context.time "
            "and keep nothing in class attributes or globals"
        )


def _reset(cls: type[Behavior], goal: Any, ticks: int) -> Iterator[str]:
    behavior = cls()
    first = _trace(behavior, goal, ticks)
    behavior.reset()
    if behavior.state is not cls.initial or behavior.finished:
        yield f"after reset it is in state {behavior.state}: do not override `reset`, use `on_reset`"
    if _trace(behavior, goal, ticks) != first:
        yield "after reset it behaves differently than when new: set everything it remembers in `on_reset`"


def _limits(cls: type[Behavior], goal: Any, ticks: int) -> Iterator[str]:
    robot, faults = ScriptedRobot(percepts(ticks)), list[Event]()
    agent = Agent(robot, [cls()], limits=Limits(budget=None))
    agent.bus.subscribe(BehaviorFaulted, faults.append)
    agent.start(cls.name, goal)
    for _ in range(ticks):
        agent.tick()
    for fault in faults:
        yield f"the agent stopped it: {getattr(fault, 'fault', fault)}"


def _speed(cls: type[Behavior], goal: Any, ticks: int) -> Iterator[str]:
    trial, durations = Trial(cls(), goal=goal), []
    for sensed in percepts(ticks):
        start = time.perf_counter()
        trial.step(sensed)
        durations.append(time.perf_counter() - start)
    if (median := statistics.median(durations)) > SLOW:
        yield f"a tick takes {median * 1e6:.0f} us (median), more than {SLOW * 1e6:.0f}: do less in each tick"


def _no_simulator_here() -> Iterator[str]:
    if loaded := [name for name in _SIMULATORS if name in sys.modules]:
        yield _LOADS.format(loaded)


def _no_simulator(cls: type[Behavior]) -> Iterator[str]:
    """Imports the plugin in a fresh process, as this one may have loaded a simulator for other reasons."""
    path = inspect.getsourcefile(cls)
    if path is None:
        return
    load = f"importlib.import_module({cls.__module__!r})"
    if cls.__module__.startswith("tolman_plugin_"):
        load = f"import_file(pathlib.Path({str(Path(path))!r}))"
    code = (
        "import importlib, pathlib, sys\nfrom tolman.plugins.loading import import_file\n"
        f"{load}\nprint([m for m in {_SIMULATORS} if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    if done.returncode != 0:
        yield f"importing it in a fresh process failed: {done.stderr.strip().splitlines()[-1:]}"
    elif (loaded := done.stdout.strip().splitlines()[-1]) != "[]":
        yield _LOADS.format(loaded)
