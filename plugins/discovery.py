"""Finds behaviors and mediators: entry points of installed distributions and .py files in folders.

Nothing is imported that is not asked for, but for the files of the folders: only importing tells which
classes they define. A broken plugin nobody asked for is kept in `Catalog.broken`, it stops nobody else.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.metadata import EntryPoint
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..agent.arbitration.mediator import Mediator
from ..agent.behavior import Behavior
from ..files.messages import unknown
from .errors import BrokenPluginError, DuplicatePluginError, UnknownPluginError
from .isolation.process import Subprocess, describe_file
from .isolation.proxy import isolated_class
from .loading import (
    BEHAVIORS,
    HANG,
    KINDS,
    MEDIATORS,
    Plugin,
    constant,
    contained,
    entries,
    is_foreign,
    load_entry,
    origin_of,
    plugin_files,
    plugins_in,
    spec_of,
)

_NONE_IN_IT = (
    "it defines no behavior and no mediator; a behavior is a class derived from tolman.agent.Behavior "
    "(put `_` before the name of a file that is only imported)"
)
_log = logging.getLogger(__name__)
Folders = Iterable[Path | str]


class Catalog:
    """All plugins that were found, by group and name."""

    def __init__(self) -> None:
        """Empty; `discover` fills one."""
        self._plugins: dict[str, dict[str, Plugin]] = {group: {} for group in KINDS}
        self.broken: dict[str, str] = {}

    def add(self, plugin: Plugin) -> None:
        """Takes a plugin in. Raises: DuplicatePluginError if another origin has its name already."""
        known = self._plugins[plugin.group]
        other = known.get(plugin.name)
        if other is not None and other.origin != plugin.origin:
            raise DuplicatePluginError(
                f"two {KINDS[plugin.group]}s are named {plugin.name!r}: {other.origin} and "
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
        raise UnknownPluginError(unknown(KINDS[group], name, sorted(known)) + broken)


def discover(folders: Folders = (), isolate: bool | Collection[str] = False) -> Catalog:
    """Finds all plugins: those of installed distributions, then the .py files of the folders.

    isolate: True, or names: plugins that are not tolman's own run in a subprocess each, and what is isolated
    is never imported here. With names all files are looked at in a subprocess first; a file with one of these
    is isolated whole.

    Raises: PluginError if a folder is none, DuplicatePluginError if two plugins share a name.
    """
    catalog = Catalog()
    for group in KINDS:
        for entry in entries(group):
            catalog.add(_of_entry(entry, group, isolate))
    for folder in folders:
        for path in plugin_files(Path(folder)):
            try:
                found = _isolated_in(path, isolate) if isolate else plugins_in(path)
            except BrokenPluginError as fault:
                catalog.broken[str(path)] = str(fault)
                continue
            if not found:
                catalog.broken[str(path)] = f"{path}: {_NONE_IN_IT}"
            for plugin in found:
                catalog.add(plugin)
    return catalog


def _isolated_in(path: Path, isolate: bool | Collection[str]) -> list[Plugin]:
    """The plugins of a file, as classes that stand for them where it is to be isolated."""
    told = describe_file(path)
    if not (isolate is True or any(each.get("name") in isolate for each in told)):  # type: ignore[operator]
        return plugins_in(path)
    return isolated_plugins(path, told)


def isolated_plugins(path: Path, told: Iterable[Mapping[str, Any]] | None = None) -> list[Plugin]:
    """The plugins of a file as classes that stand for them. told: by its subprocess, if it was asked.

    Raises: BrokenPluginError.
    """
    spec, found = spec_of(path), []
    for each in describe_file(path) if told is None else told:
        try:
            cls = isolated_class(spec, each)
        except BrokenPluginError as fault:
            raise BrokenPluginError(f"{path}: {fault}") from fault
        found.append(Plugin(cls.name, str(each["group"]), f"file {path}", constant(cls), spec))
    return found


def _of_entry(entry: EntryPoint, group: str, isolate: bool | Collection[str]) -> Plugin:
    apart = isolate if isinstance(isolate, bool) else entry.name in isolate
    spec = {"entry": entry.value, "group": group}

    def load() -> type[Any]:
        if not (apart and is_foreign(entry)):
            return load_entry(entry, group)
        child = Subprocess(spec)
        child.kill()
        try:
            return isolated_class(spec, child.hello[0])
        except (LookupError, TypeError, AttributeError):
            raise BrokenPluginError(f"{origin_of(entry)}: its subprocess says nothing sensible") from None

    return Plugin(entry.name, group, origin_of(entry), load, spec)


def _catalog(folders: Folders | Catalog, isolate: bool | Collection[str]) -> Catalog:
    return folders if isinstance(folders, Catalog) else discover(folders, isolate)


def apart(configs: Mapping[str, Mapping[str, Any]] | None, isolate: bool = False) -> bool | Collection[str]:
    """What `discover` is to isolate: all, or the behaviors with `isolate: true` among their settings."""
    return isolate or {name for name, values in (configs or {}).items() if values.get("isolate")}


def load_behaviors(
    names: Sequence[str] | None = None,
    folders: Folders | Catalog = (),
    isolate: bool | Collection[str] = False,
) -> dict[str, type[Behavior]]:
    """The behavior classes of these names, or all that can be loaded, by name.

    folders, isolate: see `discover`; or what it found.

    What cannot be loaded and was not asked for is left out, and one line of the log says why.

    Raises: UnknownPluginError, DuplicatePluginError; BrokenPluginError for a broken one asked for by name.
    """
    catalog = _catalog(folders, isolate)
    if names is not None:
        return {name: catalog.find(name).load() for name in names}
    classes: dict[str, type[Behavior]] = {}
    for name, plugin in catalog.plugins().items():
        try:
            classes[name] = plugin.load()
        except BrokenPluginError as fault:
            catalog.broken[plugin.origin] = str(fault)
    for why in catalog.broken.values():
        _log.error("plugin left out: %s", why)
    return classes


def build_behaviors(
    names: Sequence[str] | None = None,
    folders: Folders | Catalog = (),
    configs: Mapping[str, Mapping[str, Any]] | None = None,
    isolate: bool = False,
) -> dict[str, Behavior]:
    """New behaviors by name; `configs`: name -> settings, as a configuration file gives them.

    isolate: whether all that are not tolman's own run in subprocesses; else those with `isolate: true`
    among their settings. `plugins.isolation.close_all` ends the subprocesses.

    Raises: what `load_behaviors` does, ConfigError for a wrong setting, UnknownPluginError for settings of
    a behavior that is not there.
    """
    classes = load_behaviors(names, folders, apart(configs, isolate))
    settings = {name: dict(values) for name, values in (configs or {}).items()}
    for name, values in settings.items():
        values.pop("isolate", None)
        if name not in classes:
            raise UnknownPluginError(
                f"settings for {name!r}, which is not loaded; loaded: {', '.join(sorted(classes)) or 'none'}"
            )
    made = {name: _made(name, cls, settings.get(name, {})) for name, cls in classes.items()}
    return {name: behavior for name, behavior in made.items() if behavior is not None}


def _made(name: str, cls: type[Behavior], settings: Mapping[str, Any]) -> Behavior | None:
    """A new behavior; None, with a line in the log, if making it raises though nobody set anything."""
    try:
        with contained(f"behavior {name}: making one", None if cls.slow_start else HANG):
            return cls(**settings)
    except BrokenPluginError as fault:
        if settings:
            raise
        _log.error("plugin left out: %s", fault)
        return None


def load_mediator(
    name: str = "priority",
    folders: Folders | Catalog = (),
    options: Mapping[str, Any] = MappingProxyType({}),
    isolate: bool | Collection[str] = False,
) -> Mediator:
    """A new mediator of that name; options: what its constructor takes, by name.

    folders, isolate: see `discover`; or what it found.

    Raises: UnknownPluginError, ConfigError for a wrong option, BrokenPluginError if it cannot be made.
    """
    plugin = _catalog(folders, isolate).find(name, MEDIATORS)
    cls = plugin.load()
    slow = getattr(cls, "slow_start", False)
    with contained(f"mediator {name!r} of {plugin.origin}: making one", None if slow else HANG):
        mediator: Mediator = cls(**options)
    return mediator
