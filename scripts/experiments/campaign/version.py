"""Names the code that computes results, so that what another version computed is not taken up."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import resources
from importlib.metadata import version
from importlib.resources.abc import Traversable

_COMPUTING = tuple(f"tolman.{floor}" for floor in ("files", "world", "maps", "agent", "behaviors", "plugins"))
_SCRIPTS = "tolman.scripts"
_ONLY_HAND_OUT = ("experiments.campaign.", "cli.")
"""How modules are called that a run's own import, and that cannot change what comes of it."""


@cache
def code_version(script: str = "experiments.runs.mapping") -> str:
    """The package's version and a digest of the source that runs of the kind that `script` makes depend on.

    Of the scripts only those that it imports, directly or not: a new layout of the report costs no new runs.
    """
    digest = hashlib.sha256()
    for package in _COMPUTING:
        for name, entry in _files(resources.files(package), package):
            digest.update(f"{name}\n".encode())
            digest.update(entry.read_bytes())
    for name in sorted(imported_scripts(script)):
        digest.update(f"{_SCRIPTS}.{name}\n".encode())
        digest.update(_source(name))
    return f"{version('tolman')}+{digest.hexdigest()[:12]}"


def _files(folder: Traversable, name: str) -> Iterator[tuple[str, Traversable]]:
    """The source and data files in a folder and those below it, each with its path, in a fixed order."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        path = f"{name}/{entry.name}"
        if entry.is_dir():
            yield from _files(entry, path)
        elif entry.name.endswith((".py", ".yaml")):
            yield path, entry


def imported_scripts(script: str) -> set[str]:
    """The script and those that it imports, directly or not, but for those that only hand out work."""
    found: set[str] = set()
    todo = [script]
    while todo:
        name = todo.pop()
        if name not in found and not name.startswith(_ONLY_HAND_OUT):
            found.add(name)
            todo += _neighbors(name)
    return found


def _neighbors(name: str) -> Iterator[str]:
    """Modules of `tolman.scripts` that one of them imports, wherever in it; `a.b` is b in the folder a."""
    folders = name.split(".")[:-1]
    for node in ast.walk(ast.parse(_source(name))):
        if isinstance(node, ast.ImportFrom) and 1 <= node.level <= len(folders) + 1:
            place = folders[: len(folders) + 1 - node.level]
            for module in [node.module] if node.module else [alias.name for alias in node.names]:
                yield ".".join([*place, module])


def _source(name: str) -> bytes:
    *folders, module = name.split(".")
    folder = resources.files(_SCRIPTS).joinpath(*folders)
    file = folder.joinpath(f"{module}.py")
    return (file if file.is_file() else folder.joinpath(module, "__init__.py")).read_bytes()
