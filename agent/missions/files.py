"""Missions in files: a Python file with a generator function, or YAML for those who do not program."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Callable, Iterable
from hashlib import sha256
from pathlib import Path

from ...files.messages import unknown
from ...files.reading import open_regular, read_text
from ...files.yaml_nodes import MAX_BYTES, Entry, parse_yaml
from ..containment import Watchdog, describe
from ..errors import MissionError
from .step import Body, Script, Step

HANG = 10.0
"""Wall-clock seconds after which the reading of a mission's Python file is given up."""
_KEYS = ("mission", "about", "steps")


def script_in(path: Path) -> Callable[[], Script]:
    """The generator function `mission` of a Python file, which this runs. Raises: MissionError."""
    open_regular(path, MissionError).close()
    name = f"tolman_mission_{path.stem}_{sha256(str(path.resolve()).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise MissionError(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        with Watchdog(None, HANG):
            spec.loader.exec_module(module)
    except (Exception, SystemExit) as fault:
        del sys.modules[name]
        raise MissionError(f"{path}: reading it raised {describe(fault)}") from fault
    body = getattr(module, "mission", None)
    if not inspect.isgeneratorfunction(body):
        raise MissionError(f"{path}: define a generator function, `def mission():` with `yield` in it")
    if any(p.default is p.empty for p in inspect.signature(body).parameters.values()):
        raise MissionError(f"{path}: mission() must take no arguments, or only some with defaults")
    return body


def steps_in(path: Path, known: Iterable[type[Step]]) -> tuple[str, Body]:
    """Name and steps of a YAML mission. known: the steps there are. Raises: MissionError."""
    document = parse_yaml(read_text(path, MAX_BYTES, MissionError), str(path), MissionError)
    if not document.is_mapping:
        raise document.error("give `steps:`, a list such as `- go_to: 5`")
    keys = document.mapping(_KEYS, required=("steps",))
    name = keys["mission"].text() if "mission" in keys else path.stem
    return name, _StepReader(known).body(keys["steps"])


class _StepReader:
    """Makes steps of YAML values. All errors are MissionError and name file, line and key."""

    def __init__(self, known: Iterable[type[Step]]) -> None:
        self._known = {cls.word: cls for cls in known}

    def body(self, entry: Entry) -> Body:
        """The step that is described, or the steps of a list."""
        if not entry.is_list:
            return self._step(entry)
        if not entry.items():
            raise entry.error("an empty list of steps")
        steps = tuple(entry.each(self._step))
        return steps if len(steps) > 1 else steps[0]

    def _step(self, entry: Entry) -> Body:
        if entry.is_scalar and not entry.is_nothing:
            word = entry.text()
            value = entry.substituted(word, "")
        elif entry.is_mapping and len(entry.mapping()) == 1:
            ((word, value),) = entry.mapping().items()
        else:
            raise entry.error(f"a step is one key with its value, such as `go_to: 5`, not {entry.found()}")
        if word == "steps":
            return self.body(value)
        if word not in self._known:
            raise entry.error(unknown("step", word, sorted(self._known)))
        return self._known[word].read(value, self.body)
