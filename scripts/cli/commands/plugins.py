"""`tolman plugins`: lists, checks, writes and draws plugins."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ....files.messages import printable
from ....plugins.check import Report
from ....plugins.diagram import draw, mermaid
from ....plugins.discovery import Catalog, discover, isolated_plugins
from ....plugins.errors import PluginError
from ....plugins.isolation.checking import check_apart
from ....plugins.loading import BEHAVIORS, MEDIATORS, Plugin, contained, plugin_files, plugins_in
from ....plugins.template import write_plugin
from ...errors import UsageError
from ..command import Command
from ..options import add_json, one_of, picture
from ..output import check_output, print_json, stdout_to_stderr

ACTIONS = ("list", "check", "new", "diagram")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman plugins`."""
    parser.add_argument(
        "action",
        nargs="?",
        default="list",
        type=one_of(*ACTIONS),
        metavar="ACTION",
        help="list (default), check, new or diagram",
    )
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="a plugin's name; for check also a file or folder"
    )
    parser.add_argument(
        "--plugins",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="folder whose .py files hold further plugins (may be given more than once)",
    )
    parser.add_argument(
        "--isolate",
        action="store_true",
        help="import nothing of --plugins here: ask subprocesses that can do no harm",
    )
    parser.add_argument(
        "--folder",
        type=Path,
        default=Path("plugins"),
        metavar="DIR",
        help="where `new` writes (plugins)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=picture,
        metavar="PNG",
        help="where `diagram` draws; else it prints Mermaid text",
    )
    parser.add_argument("--force", action="store_true", help="replace an existing picture")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Does what the action says. Status 1: a checked plugin does not conform."""
    if options.action == "list":
        return _list(options)
    if options.name is None:
        raise UsageError(f"`tolman plugins {options.action}` needs a name")
    if options.action == "check":
        return _check(options)
    if options.action == "new":
        paths = write_plugin(options.name, options.folder)
        print("\n".join(str(path) for path in paths))
        print(f"next: python -m pytest {paths[1]}", file=sys.stderr)
        return 0
    return _diagram(options)


def _entry(plugin: Plugin) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": plugin.name, "origin": plugin.origin}
    try:
        cls = plugin.load()
        with contained(f"{plugin.origin}: looking at it"):
            about = printable(str(cls.__doc__ or "").strip().partition("\n")[0])
            return entry | {"about": about, "priority": getattr(cls, "priority", None)}
    except PluginError as fault:
        return entry | {"broken": str(fault)}


def _list(options: argparse.Namespace) -> int:
    with stdout_to_stderr():  # a plugin that prints spoils no list
        catalog = discover(options.plugins, options.isolate)
        behaviors = [_entry(plugin) for plugin in catalog.plugins(BEHAVIORS).values()]
        mediators = [_entry(plugin) for plugin in catalog.plugins(MEDIATORS).values()]
    if options.json:
        print_json({"behaviors": behaviors, "mediators": mediators, "broken": catalog.broken})
        return 0
    behaviors.sort(key=lambda entry: (-(entry.get("priority") or 0), entry["name"]))
    for title, found in (("behaviors", behaviors), ("mediators", mediators)):
        print(f"{title}:")
        for entry in found:
            priority = entry.get("priority")
            rank = f"{priority:>3}" if isinstance(priority, int) else "   "
            print(f"  {entry['name']:<20} {rank}  {entry.get('about') or entry.get('broken', '')}")
    _tell_broken(catalog)
    return 0


def _tell_broken(catalog: Catalog) -> None:
    for origin, why in catalog.broken.items():
        print(f"could not be read: {why if why.startswith(origin) else f'{origin}: {why}'}", file=sys.stderr)


def _check(options: argparse.Namespace) -> int:
    """Checks in a subprocess each: what exits or hangs there gives no verdict."""
    found = [spec for plugin in _chosen(options, True) for spec in [{**plugin.spec, "name": plugin.name}]]
    reports = [report for spec in found for report in check_apart(spec, options.isolate)]
    if options.json:
        print_json(
            {"passed": all(report.passed for report in reports), "plugins": [_plain(r) for r in reports]}
        )
    else:
        print("\n".join(report.text() for report in reports))
    return 0 if all(report.passed for report in reports) else 1


def _plain(report: Report) -> dict[str, Any]:
    findings = [{"check": f.check, "passed": f.passed, "fix": f.fix} for f in report.findings]
    return {"name": report.name, "passed": report.passed, "findings": findings}


def _chosen(options: argparse.Namespace, isolate: bool) -> list[Plugin]:
    """The behaviors meant by a name, a file or a folder."""
    read = isolated_plugins if isolate else plugins_in
    path = Path(options.name)
    if path.suffix == ".py" or path.is_dir():
        if not path.exists():
            raise UsageError(f"{path}: there is no such file")
        files = plugin_files(path) if path.is_dir() else [path]
        found = [plugin for file in files for plugin in read(file) if plugin.group == BEHAVIORS]
        if not found:
            raise UsageError(f"{path}: no behavior in it; a behavior is a class derived from Behavior")
        return found
    return [discover(options.plugins, isolate).find(options.name)]


def _diagram(options: argparse.Namespace) -> int:
    with stdout_to_stderr():
        classes = [plugin.load() for plugin in _chosen(options, options.isolate)]
    if options.output is None:
        print("\n".join(mermaid(cls) for cls in classes), end="")
        return 0
    if len(classes) > 1:
        raise UsageError(f"{options.name} holds several behaviors; name one")
    draw(classes[0], check_output(options.output, replace=options.force))
    return 0


COMMAND = Command(
    "plugins",
    "Lists the behaviors and mediators that are found; `check NAME-OR-PATH` says whether one keeps the\n"
    "contract and what to fix; `new NAME` writes a behavior with its test; `diagram NAME` draws its states.",
    add_arguments,
    run,
)
