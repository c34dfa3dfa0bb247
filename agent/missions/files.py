"""Missions in files: a Python file with a generator function, or YAML for those who do not program."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from .. import events
from ..containment import describe
from ..errors import MissionError
from ..recording.codec import known_classes
from .mission import Mission
from .steps import (
    As,
    Body,
    Do,
    Explore,
    Fail,
    ForEachNode,
    GoTo,
    Load,
    Look,
    Nodes,
    OnFailure,
    Place,
    Race,
    Repeat,
    Save,
    Say,
    Step,
    Together,
    Until,
    Wait,
    Within,
)

NODE = "$node"
"""What stands for the node's number in the steps of `for_each_node`."""


def load_mission(path: Path) -> Mission:
    """Reads a .py or .yaml mission. Raises: MissionError, which names the file, the place and the fault."""
    if not path.is_file():
        raise MissionError(f"{path}: there is no such mission file")
    if path.suffix == ".py":
        return _from_python(path)
    if path.suffix in (".yaml", ".yml"):
        return _from_yaml(path)
    raise MissionError(f"{path}: a mission ends in .py, .yaml or .yml")


def _from_python(path: Path) -> Mission:
    name = f"tolman_mission_{path.stem}_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise MissionError(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as fault:
        del sys.modules[name]
        raise MissionError(f"{path}: reading it raised {describe(fault)}") from fault
    body = getattr(module, "mission", None)
    if not inspect.isgeneratorfunction(body):
        raise MissionError(f"{path}: define a generator function, `def mission():` with `yield` in it")
    if any(p.default is p.empty for p in inspect.signature(body).parameters.values()):
        raise MissionError(f"{path}: mission() must take no arguments, or only some with defaults")
    return Mission(path.stem, body)


def _from_yaml(path: Path) -> Mission:
    import yaml

    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as fault:
        raise MissionError(f"{path}: not YAML: {' '.join(str(fault).split())}") from fault
    if not isinstance(document, dict) or "steps" not in document:
        raise MissionError(f"{path}: give `steps:`, a list such as `- go_to: 5`")
    for key in document:
        if key not in ("mission", "steps", "about"):
            raise MissionError(f"{path}: unknown key {key!r}; known: mission, about, steps")
    steps = read_steps(document["steps"], f"{path}: steps")
    return Mission.of(str(document.get("mission", path.stem)), *steps)


def read_steps(entries: Any, where: str) -> tuple[Body, ...]:
    """Steps from a YAML list, or from a single entry. Raises: MissionError."""
    if not isinstance(entries, list):
        return (_step(entries, where),)
    if not entries:
        raise MissionError(f"{where}: an empty list of steps")
    return tuple(_step(entry, f"{where}[{index}]") for index, entry in enumerate(entries, start=1))


def _one(entries: Any, where: str) -> Body:
    steps = read_steps(entries, where)
    return steps[0] if len(steps) == 1 else steps


def _step(entry: Any, where: str) -> Body:
    if isinstance(entry, str):
        entry = {entry: None}
    if not isinstance(entry, dict) or len(entry) != 1:
        raise MissionError(f"{where}: a step is one key with its value, such as `go_to: 5`, not {entry!r}")
    ((word, value),) = entry.items()
    if word not in _WORDS:
        near = get_close_matches(str(word), _WORDS, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        raise MissionError(f"{where}: unknown step {word!r}; {hint}known: {', '.join(sorted(_WORDS))}")
    try:
        return _WORDS[word](value, f"{where}.{word}")
    except (TypeError, KeyError, ValueError) as fault:
        if isinstance(fault, MissionError):
            raise
        raise MissionError(f"{where}.{word}: {describe(fault)}") from fault


def _fields(value: Any, where: str, *known: str, single: str | None = None) -> dict[str, Any]:
    """The value as a mapping with known keys; `single` names the key of a value that is none."""
    if value is None:
        return {}
    if not isinstance(value, dict):
        if single is None:
            raise MissionError(f"{where}: give {', '.join(known)}, not {value!r}")
        return {single: value}
    for key in value:
        if key not in known:
            raise MissionError(f"{where}: unknown key {key!r}; known: {', '.join(known)}")
    return value


def _needed(value: Any, where: str, kind: type | tuple[type, ...], what: str) -> Any:
    if isinstance(value, bool) or not isinstance(value, kind):
        raise MissionError(f"{where}: give {what}, not {value!r}")
    return value


def _explore(value: Any, where: str) -> Step:
    given = _fields(value, where, "side", "strategy", "max_nodes", "wait", "islands", single="side")
    if given.get("side", "right") not in ("right", "left"):
        raise MissionError(f"{where}: side is right or left, not {given['side']!r}")
    return Explore(**given)


def _until(value: Any, where: str) -> Step:
    given = _fields(value, where, "event", "timeout", "where", single="event")
    name = str(given.get("event", ""))
    kinds = {cls_name: cls for cls_name, cls in known_classes().items() if issubclass(cls, events.Event)}
    if name not in kinds:
        near = get_close_matches(name, kinds, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        raise MissionError(f"{where}: unknown event {name!r}; {hint}known: {', '.join(sorted(kinds))}")
    return Until(kinds[name], given.get("timeout"), given.get("where") or {})


def _do(value: Any, where: str) -> Step:
    given = _fields(value, where, "behavior", "goal", single="behavior")
    goal = given.get("goal")
    if isinstance(goal, dict):
        if len(goal) != 1 or (cls := known_classes().get(next(iter(goal)))) is None:
            raise MissionError(f"{where}.goal: give a kind of goal and its settings, as Foray: {{turn: 1}}")
        goal = cls(**(next(iter(goal.values())) or {}))
    return Do(_needed(given.get("behavior"), where, str, "the behavior's name"), goal)


def _repeat(value: Any, where: str) -> Step:
    given = _fields(value, where, "times", "steps")
    times = given.get("times")
    if times is not None:
        _needed(times, f"{where}.times", int, "a whole number")
    return Repeat(_one(given.get("steps"), f"{where}.steps"), times)


def _on_failure(value: Any, where: str) -> Step:
    given = _fields(value, where, "do", "otherwise", "retries")
    otherwise = given.get("otherwise")
    return OnFailure(
        _one(given.get("do"), f"{where}.do"),
        None if otherwise is None else _one(otherwise, f"{where}.otherwise"),
        _needed(given.get("retries", 0), f"{where}.retries", int, "a whole number"),
    )


def _within(value: Any, where: str) -> Step:
    given = _fields(value, where, "seconds", "steps")
    seconds = _needed(given.get("seconds"), f"{where}.seconds", (int, float), "a number of seconds")
    return Within(seconds, _one(given.get("steps"), f"{where}.steps"))


def _as(value: Any, where: str) -> Step:
    given = _fields(value, where, "robot", "steps")
    robot = _needed(given.get("robot"), f"{where}.robot", int, "a robot's number")
    return As(robot, _one(given.get("steps"), f"{where}.steps"))


def _for_each_node(value: Any, where: str) -> Step:
    read_steps(_with_node(value, 0), where)  # so that a fault is found now, not at the first node
    return ForEachNode(_NodeBody(value, where))


class _NodeBody:
    """The steps for one node."""

    def __init__(self, entries: Any, where: str) -> None:
        self._entries, self._where = entries, where
        self.__name__ = "steps"

    def __call__(self, node: int) -> Body:
        return _one(_with_node(self._entries, node), self._where)


def _with_node(entries: Any, node: int) -> Any:
    if isinstance(entries, dict):
        return {key: _with_node(value, node) for key, value in entries.items()}
    if isinstance(entries, list):
        return [_with_node(value, node) for value in entries]
    if isinstance(entries, str):
        return node if entries == NODE else entries.replace(NODE, str(node))
    return entries


_NUMBER = (int, float)
_WORDS: dict[str, Callable[[Any, str], Body]] = {
    "explore": _explore,
    "go_to": lambda value, where: GoTo(_needed(value, where, (int, str), "a node's number or name")),
    "save": lambda value, where: Save(_needed(value, where, str, "a file")),
    "load": lambda value, where: Load(_needed(value, where, str, "a file")),
    "place": lambda value, where: Place(_needed(value, where, (int, str), "a node's number or name")),
    "as": _as,
    "nodes": lambda value, where: Nodes(),
    "look": lambda value, where: Look(),
    "do": _do,
    "until": _until,
    "wait": lambda value, where: Wait(_needed(value, where, _NUMBER, "a number of seconds")),
    "say": lambda value, where: Say(str(value)),
    "fail": lambda value, where: Fail(str(value)),
    "race": lambda value, where: Race(*read_steps(value, where)),
    "together": lambda value, where: Together(*read_steps(value, where)),
    "steps": read_steps,
    "within": _within,
    "repeat": _repeat,
    "on_failure": _on_failure,
    "for_each_node": _for_each_node,
}
