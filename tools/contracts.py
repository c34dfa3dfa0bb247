"""Checks the contracts between packages and rooms, which pyproject.toml states: `python -m tools.contracts`.

import-linter takes the packages of a namespace, or one package with all its modules below its own folder.
Ours lie beside `tolman/`, which is a package for the front door's sake: for the check it is a namespace.
"""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec
from types import ModuleType

from importlinter.cli import lint_imports_command


def main() -> None:
    """Runs import-linter with the arguments of the command line; its status is the process's."""
    namespace = ModuleType("tolman")
    namespace.__spec__ = ModuleSpec("tolman", None, is_package=True)
    namespace.__path__ = []
    sys.modules["tolman"] = namespace
    lint_imports_command()


if __name__ == "__main__":
    main()
