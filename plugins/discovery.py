"""Finds behaviors and mediators: entry points of installed distributions and .py files in folders.

Nothing is imported that is not asked for, but for the files of the folders: only importing tells which
classes they define. A broken plugin nobody asked for is kept in `Catalog.broken`, it stops nobody else.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import inspect
import logging
import sys
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from ..agent.arbitration.mediator import Mediator
from ..agent.behavior import Behavior, check_declarations
from ..agent.containment import describe
from ..agent.errors import AgentError, ConfigError
from ..files.messages import unknown
from .errors import BrokenPluginError, DuplicatePluginError, IsolationError, PluginError, UnknownPluginError
from .isolation.proxy import Subprocess, describe_file, isolated_class

BEHAVIORS = "tolman.behaviors"
MEDIATORS = "tolman.mediators"
_FAULTS = (Exception, SystemExit)
"""What a plugin may raise without ending whoever looks for plugins."""
_NONE_IN_IT = (
    "it defines no behavior and no mediator; a behavior is a class derived from tolman.agent.Behavior "
    "(put `_` before the name of a file that is only imported)"
)
_log = logging.getLogger(__name__)
_KINDS = {BEHAVIORS: "behavior", MEDIATORS: "mediator"}


@dataclass(frozen=True, slots=True)
class Plugin:
    """One plugin that was found: its name, its group, where it comes from and how to load its class."""

    name: str
    group: str
    origin: str
    load: Callable[[], type[Any]]


class Catalog:
    """All plugins that were found, by group and name."""

    def __init__(self) -> None:
        """Empty; `discover` fills one."""
        self._plugins: dict[str, dict[str, Plugin]] = {group: {} for group in _KINDS}
        self.broken: dict[str, str] = {}

    def add(self, plugin: Plugin) -> None:
        """Takes a plugin in. Raises: DuplicatePluginError if another origin has its name already."""
        known = self._plugins[plugin.group]
        other = known.get(plugin.name)
        if other is not None and other.origin != plugin.origin:
            raise DuplicatePluginError(
                f"two {_KINDS[plugin.group]}s are named {plugin.name!r}: {other.origin} and "
                f"{plugin.origin}; rename or leave out one"
            )
        known[plugin.name] = plugin

    def plugins(self, group: str = BEHAVIORS) -> dict[str, Plugin]:
        """The plugins of a group by name, sorted."""
        return dict(sorted(self._plugins[group].items()))

    def find(self, name: str, group: str = BEHAVIORS) -> Plugin:
        """The plugin of that name. Raises: UnknownPluginError with the nearest and the known names."""
        known = self._plugins[group]
        if name in known:
            return known[name]
        broken = "".join(f"; could not be read: {origin} ({why})" for origin, why in self.broken.items())
        raise UnknownPluginError(unknown(_KINDS[group], name, sorted(known)) + broken)


def discover(folders: Iterable[Path | str] = (), isolate: bool | Collection[str] = False) -> Catalog:
    """Finds all plugins: those of installed distributions, then the .py files of the folders.

    isolate: True, or names: behaviors that are not tolman's own run in a subprocess each, and what is
    isolated is never imported here; with names all files are looked at in a subprocess first.

    Raises: PluginError if a folder is none, DuplicatePluginError if two plugins share a name.
    """
    catalog = Catalog()
    for group in _KINDS:
        for entry in entry_points(group=group):
            catalog.add(Plugin(entry.name, group, _origin(entry), _entry_loader(entry, group, isolate)))
    for folder in folders:
        for path in plugin_files(Path(folder)):
            try:
                found = _isolated_in(path, isolate) if isolate else plugins_in(path)
            except (BrokenPluginError, IsolationError) as fault:
                catalog.broken[str(path)] = str(fault)
                continue
            if not found:
                catalog.broken[str(path)] = f"{path}: {_NONE_IN_IT}"
            for plugin in found:
                catalog.add(plugin)
    return catalog


def plugin_files(folder: Path) -> list[Path]:
    """The .py files of a folder that may hold plugins, sorted; tests and names with `_` first are not."""
    if not folder.is_dir():
        raise PluginError(f"plugin folder {folder}: no such folder; give one that holds .py files")
    skipped = ("_", "test_", "conftest", "setup.py")
    return sorted(path for path in folder.glob("*.py") if not path.name.startswith(skipped))


def _isolated_in(path: Path, isolate: bool | Collection[str]) -> list[Plugin]:
    """The behaviors of a file, those to isolate as classes that stand for them."""
    spec = {"file": str(path.resolve())}
    hellos = describe_file(path)
    apart = [hello for hello in hellos if isolate is True or hello["name"] in isolate]  # type: ignore[operator]
    found = [
        Plugin(hello["name"], BEHAVIORS, f"file {path}", _constant(isolated_class(spec, hello)))
        for hello in apart
    ]
    names = {plugin.name for plugin in found}
    if len(apart) < len(hellos):
        found += [plugin for plugin in plugins_in(path) if plugin.name not in names]
    return found


def plugins_in(path: Path) -> list[Plugin]:
    """The behaviors and mediators that one .py file defines (not those it imports).

    Raises: BrokenPluginError if importing it fails; it names the file and the fault.
    """
    module = import_file(path)
    origin = f"file {path}"
    found = []
    for value in vars(module).values():
        if not inspect.isclass(value) or value.__module__ != module.__name__ or inspect.isabstract(value):
            continue
        group = _group_of(value)
        nameless_base = group == BEHAVIORS and not getattr(value, "name", "") and value.__subclasses__()
        if group is not None and not nameless_base:
            found.append(Plugin(_checked(value, group, origin).name, group, origin, _constant(value)))
    return found


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
        spec.loader.exec_module(module)
    except _FAULTS as fault:
        del sys.modules[name]
        raise BrokenPluginError(f"{path}: importing it raised {describe(fault)}") from fault
    return module


def load_behaviors(
    names: Sequence[str] | None = None,
    folders: Iterable[Path | str] = (),
    isolate: bool | Collection[str] = False,
) -> dict[str, type[Behavior]]:
    """The behavior classes of these names, or all that can be loaded, by name. isolate: see `discover`.

    What cannot be loaded and was not asked for is left out, and one line of the log says why.

    Raises: UnknownPluginError, DuplicatePluginError; BrokenPluginError for a broken one asked for by name.
    """
    catalog = discover(folders, isolate)
    if names is not None:
        return {name: catalog.find(name).load() for name in names}
    classes: dict[str, type[Behavior]] = {}
    for name, plugin in catalog.plugins().items():
        try:
            classes[name] = plugin.load()
        except (BrokenPluginError, IsolationError) as fault:
            catalog.broken[plugin.origin] = str(fault)
    for why in catalog.broken.values():
        _log.error("plugin left out: %s", why)
    return classes


def build_behaviors(
    names: Sequence[str] | None = None,
    folders: Iterable[Path | str] = (),
    configs: Mapping[str, Mapping[str, Any]] | None = None,
    isolate: bool = False,
) -> dict[str, Behavior]:
    """New behaviors by name; `configs`: name -> settings, as a configuration file gives them.

    isolate: whether all that are not tolman's own run in subprocesses; else those with `isolate: true`
    among their settings. `plugins.isolation.close_all` ends the subprocesses.

    Raises: what `load_behaviors` does, ConfigError for a wrong setting, UnknownPluginError for settings of
    a behavior that is not there.
    """
    settings = {name: dict(values) for name, values in (configs or {}).items()}
    apart = {name for name, values in settings.items() if values.pop("isolate", False)}
    classes = load_behaviors(names, folders, isolate or apart)
    for name in settings:
        if name not in classes:
            raise UnknownPluginError(
                f"settings for {name!r}, which is not loaded; loaded: {', '.join(sorted(classes)) or 'none'}"
            )
    made = {name: _made(name, cls, settings.get(name, {})) for name, cls in classes.items()}
    return {name: behavior for name, behavior in made.items() if behavior is not None}


def _made(name: str, cls: type[Behavior], settings: Mapping[str, Any]) -> Behavior | None:
    """A new behavior; None, with a line in the log, if making it raises though nobody set anything."""
    try:
        return cls(**settings)
    except ConfigError:
        raise
    except _FAULTS as fault:
        if settings:
            raise BrokenPluginError(f"behavior {name!r}: making one raised {describe(fault)}") from fault
        _log.error("plugin left out: behavior %s: making one raised %s", name, describe(fault))
        return None


def isolating(
    configs: Mapping[str, Mapping[str, Any]] | None, folders: Iterable[Path | str]
) -> dict[str, dict[str, Any]]:
    """The same settings, with `isolate: true` for every behavior that the folders hold.

    Raises: PluginError if a folder is none. Files that cannot be read are left to `discover` to report.
    """
    settings = {name: dict(values) for name, values in (configs or {}).items()}
    for folder in folders:
        for path in plugin_files(Path(folder)):
            with contextlib.suppress(BrokenPluginError, IsolationError):
                for hello in describe_file(path):
                    settings.setdefault(hello["name"], {})["isolate"] = True
    return settings


def load_mediator(
    name: str = "priority",
    folders: Iterable[Path | str] = (),
    options: Mapping[str, Any] = MappingProxyType({}),
) -> Mediator:
    """A new mediator of that name; options: what its constructor takes, by name.

    Raises: UnknownPluginError, ConfigError for a wrong option, BrokenPluginError if it cannot be made.
    """
    plugin = discover(folders).find(name, MEDIATORS)
    cls = plugin.load()
    try:
        mediator: Mediator = cls(**options)
    except ConfigError:
        raise
    except _FAULTS as fault:
        raise BrokenPluginError(
            f"mediator {name!r} of {plugin.origin}: making one raised {describe(fault)}"
        ) from fault
    return mediator


def _origin(entry: EntryPoint) -> str:
    distribution = entry.dist.name if entry.dist is not None else "unknown distribution"
    return f"{distribution} ({entry.value})"


def _entry_loader(entry: EntryPoint, group: str, isolate: bool | Collection[str]) -> Callable[[], type[Any]]:
    foreign = entry.dist is None or entry.dist.name != "tolman"
    chosen = isolate is True or (not isinstance(isolate, bool) and entry.name in isolate)

    def load() -> type[Any]:
        if group == BEHAVIORS and foreign and chosen:
            return _isolated_entry(entry)
        try:
            value = entry.load()
        except _FAULTS as fault:
            raise BrokenPluginError(
                f"{_KINDS[group]} {entry.name!r} of {_origin(entry)}: loading it raised {describe(fault)}"
            ) from fault
        if _group_of(value) != group:
            raise BrokenPluginError(f"{entry.name!r} of {_origin(entry)} is not a {_KINDS[group]} class")
        cls = _checked(value, group, _origin(entry))
        if cls.name != entry.name:
            raise BrokenPluginError(
                f"{_origin(entry)} is entered as {entry.name!r} but its class says name = {cls.name!r}"
            )
        return cls

    return load


def _isolated_entry(entry: EntryPoint) -> type[Any]:
    child = Subprocess({"name": entry.name})
    hello = child.hello[0]
    child.kill()
    return isolated_class({"entry": entry.value}, hello)


def _constant(value: type[Any]) -> Callable[[], type[Any]]:
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
        except AgentError as fault:
            raise BrokenPluginError(f"{origin}: {fault}") from fault
    return cls
