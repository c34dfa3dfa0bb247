"""Imports plugins: one .py file or one entry point, and says which classes in it are behaviors or mediators.

Whatever a plugin raises on the way, or a loop without end, is a `BrokenPluginError` of one line.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from ..agent.behavior import Behavior, check_declarations
from ..agent.containment import Watchdog, describe
from ..agent.errors import ConfigError
from ..files.interrupts import ends_run
from ..files.messages import printable
from .errors import BrokenPluginError, PluginError

BEHAVIORS = "tolman.behaviors"
MEDIATORS = "tolman.mediators"
KINDS = {BEHAVIORS: "behavior", MEDIATORS: "mediator"}
IMPORT_TIME = 10.0
"""Wall-clock seconds after which an import is interrupted (main thread, POSIX)."""
HANG = 2.0
"""The same for making a behavior or mediator, and for a behavior where plugins from folders are loaded."""


@dataclass(frozen=True, slots=True)
class Plugin:
    """One plugin that was found: its name, its group, where it comes from and how to load its class.

    spec: where it is, for a subprocess: `file`, or `entry` and `group`.
    """

    name: str
    group: str
    origin: str
    load: Callable[[], type[Any]]
    spec: Mapping[str, str]


@contextlib.contextmanager
def contained(doing: str, hang: float | None = HANG) -> Iterator[None]:
    """Turns whatever the code inside raises into a BrokenPluginError: `doing`, then what it raised.

    hang: wall-clock seconds after which it is interrupted. Errors of plugins and of settings pass.
    """
    try:
        with Watchdog(None, hang):
            yield
    except (PluginError, ConfigError):
        raise
    except BaseException as fault:
        if ends_run(fault):
            raise
        raise BrokenPluginError(f"{doing} raised {describe(fault)}") from fault


def plugin_files(folder: Path) -> list[Path]:
    """The .py files of a folder that may hold plugins, sorted; tests and names with `_` first are not."""
    if not folder.is_dir():
        raise PluginError(
            f"plugin folder {printable(str(folder))}: no such folder; give one that holds .py files"
        )
    skipped = ("_", "test_", "conftest", "setup.py")
    return sorted(path for path in folder.glob("*.py") if not path.name.startswith(skipped))


def import_file(path: Path) -> ModuleType:
    """Imports a .py file under a name of its own, so that no two files get in each other's way."""
    path = path.resolve()
    digest = hashlib.sha256(str(path).encode()).hexdigest()[:12]
    name = f"tolman_plugin_{path.stem}_{digest}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise BrokenPluginError(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up there
    try:
        with contained(f"{path}: importing it", IMPORT_TIME):
            spec.loader.exec_module(module)
    except BaseException:
        sys.modules.pop(name, None)
        raise
    return module


def plugins_in(path: Path) -> list[Plugin]:
    """The behaviors and mediators that one .py file defines (not those it imports).

    Raises: BrokenPluginError if importing it fails; it names the file and the fault.
    """
    module = import_file(path)
    origin, found = f"file {path}", []
    with contained(f"{path}: looking at its classes"):
        for value in list(vars(module).values()):
            if not inspect.isclass(value) or value.__module__ != module.__name__ or inspect.isabstract(value):
                continue
            group = _group_of(value)
            nameless_base = group == BEHAVIORS and not getattr(value, "name", "") and value.__subclasses__()
            if group is not None and not nameless_base:
                name = _checked(value, group, origin).name
                found.append(Plugin(name, group, origin, constant(value), spec_of(path)))
    return found


def entries(group: str) -> list[EntryPoint]:
    """The entry points of a group, of all installed distributions."""
    return list(entry_points(group=group))


def is_foreign(entry: EntryPoint) -> bool:
    """Whether it is of another distribution than tolman's own."""
    return entry.dist is None or entry.dist.name != "tolman"


def origin_of(entry: EntryPoint) -> str:
    """Where an entry point comes from, in words."""
    distribution = entry.dist.name if entry.dist is not None else "unknown distribution"
    return f"{distribution} ({entry.value})"


def load_entry(entry: EntryPoint, group: str) -> type[Any]:
    """The class of an entry point. Raises: BrokenPluginError."""
    origin = origin_of(entry)
    with contained(
        f"{KINDS[group]} {entry.name!r} of {origin}: loading it", IMPORT_TIME if is_foreign(entry) else None
    ):
        value = entry.load()
        if _group_of(value) != group:
            raise BrokenPluginError(f"{entry.name!r} of {origin} is not a {KINDS[group]} class")
        cls = _checked(value, group, origin)
        if cls.name != entry.name:
            raise BrokenPluginError(
                f"{origin} is entered as {entry.name!r} but its class says name = {cls.name!r}"
            )
    return cls


def spec_of(path: Path) -> dict[str, str]:
    """Where the plugins of a file are, for a subprocess."""
    return {"file": str(path.resolve())}


def constant(value: type[Any]) -> Callable[[], type[Any]]:
    """A loader of a class that is there."""
    return lambda: value


def _group_of(value: Any) -> str | None:
    if not inspect.isclass(value):
        return None
    if issubclass(value, Behavior):
        return BEHAVIORS
    if callable(getattr(value, "arbitrate", None)) and isinstance(getattr(value, "name", None), str):
        return MEDIATORS
    return None


def _checked(cls: type[Any], group: str, origin: str) -> type[Any]:
    if group == BEHAVIORS:
        try:
            check_declarations(cls)
        except (TypeError, ValueError) as fault:
            raise BrokenPluginError(f"{origin}: {describe(fault, kind=False)}") from fault
    return cls
