"""Writes docs/behaviors.md: what each built-in behavior is, its settings and its state diagram.

Run with `python -m tools.draw_behaviors docs/behaviors.md` after a behavior was changed; a test
compares.
"""

from __future__ import annotations

import argparse
import inspect
from dataclasses import fields
from pathlib import Path

from tolman.agent.behavior import Behavior
from tolman.plugins.diagram import mermaid
from tolman.plugins.discovery import discover

HEAD = """# The built-in behaviors

Written by `tools/draw_behaviors.py` from the classes themselves; strongest first.
"""


def built_in() -> list[type[Behavior]]:
    """tolman's own behaviors, strongest first."""
    own = [plugin for plugin in discover().plugins().values() if plugin.origin.startswith("tolman (")]
    classes = [plugin.load() for plugin in own]
    return sorted(classes, key=lambda cls: (-cls.priority, cls.name))


def section(cls: type[Behavior]) -> str:
    """One behavior's part of the page."""
    lines = [f"## {cls.name} (priority {cls.priority})", "", inspect.getdoc(cls) or "", ""]
    settings = fields(cls.Config)
    if settings:
        shown = ", ".join(f"`{each.name}` {each.default!r}" for each in settings)
        lines += [inspect.getdoc(cls.Config) or "", "", f"Defaults: {shown}.", ""]
    return "\n".join([*lines, f"```mermaid\n{mermaid(cls)}```", ""])


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD, *(section(cls) for cls in built_in())])


def main() -> None:
    """Writes the page to the path that is given."""
    parser = argparse.ArgumentParser(prog="draw_behaviors", description=__doc__)
    parser.add_argument("path", type=Path)
    parser.parse_args().path.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
