"""Follows the tutorial word for word: writes its files, runs its commands, compares their output."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
BLOCK = re.compile(r"^```(\w+)(?: title=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def run(command: str, folder: Path) -> str:
    words = shlex.split(command)
    if words[0] == "python":
        words[0] = sys.executable
    elif words[0] == "tolman":
        words[:1] = [sys.executable, "-m", "tolman.scripts.cli"]
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout + done.stderr


def follow(page: Path, folder: Path) -> int:
    """Does what the page says; returns how many commands were run."""
    commands = 0
    for kind, title, text in BLOCK.findall(page.read_text()):
        if title:
            path = folder / title
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        elif kind == "console":
            output = ""
            for line in text.splitlines():
                if line.startswith("$ "):
                    output = run(line[2:], folder)
                    commands += 1
                else:
                    assert line in output, f"expected {line!r} in\n{output}"
    return commands


@pytest.mark.e2e
def test_the_first_behavior_is_written_tested_and_driven_as_the_tutorial_says(tmp_path: Path) -> None:
    assert follow(DOCS / "tutorials" / "first-behavior.md", tmp_path) == 7


def test_what_a_page_promises_and_a_command_does_not_print_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```console\n$ python -c 'print(1)'\n2\n```\n")
    with pytest.raises(AssertionError, match="expected '2'"):
        follow(page, tmp_path)
