"""Both tutorials, word for word, in a clone and an environment that nothing else has touched."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BLOCK = re.compile(
    r"^```(?P<kind>\w+)(?: title=(?P<title>\S+))?\n(?P<text>.*?)^```$|^(?P<indented>(?: {4}\$ [^\n]*\n)+)",
    re.MULTILINE | re.DOTALL,
)
MARK = "=== what follows is printed by command"


def script_of(page: str) -> tuple[str, list[tuple[str, list[str]]]]:
    """A shell script that does what the page says, and its commands, each with lines it is to print."""
    lines: list[str] = ["set -e"]
    expected: list[tuple[str, list[str]]] = []
    for block in BLOCK.finditer(page):
        if block["title"]:
            end = "END_OF_FILE"
            lines.append(f"mkdir -p $(dirname {block['title']})\ncat > {block['title']} <<'{end}'")
            lines.append(f"{block['text']}{end}")
        elif block["indented"] or block["kind"] == "console":
            for line in (block["indented"] or block["text"]).splitlines():
                command = line.strip().removeprefix("$ ") if line.strip().startswith("$ ") else ""
                if command:
                    lines.append(f"echo '{MARK} {len(expected)}'\n{command}")
                    expected.append((command, []))
                else:
                    expected[-1][1].append(line)
    return "\n".join(lines), expected


def follow(page: str, folder: Path) -> int:
    """Does what the page says, in one shell; returns how many commands were run."""
    script, expected = script_of(page)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "VIRTUAL"))}
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=folder, env=kept, text=True, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]
    printed = re.split(rf"^{MARK} \d+\n", done.stdout, flags=re.MULTILINE)[1:]
    for (command, lines), output in zip(expected, printed, strict=True):
        for line in lines:
            assert line in output, f"{command}: expected {line!r} in\n{output}"
    return len(expected)


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of this checkout that git tracks or would, as a newcomer gets them."""
    folder = tmp_path_factory.mktemp("newcomer") / "tolman"
    named = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, check=True, text=True,
    )  # fmt: skip
    for name in filter(None, named.stdout.split("\0")):
        source, target = ROOT / name, folder / name
        if not os.path.lexists(source):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_symlink():
            target.symlink_to(os.readlink(source))
        else:
            target.write_bytes(source.read_bytes())
    return folder


@pytest.mark.e2e
@pytest.mark.parametrize(("page", "commands"), [("first-behavior.md", 10), ("first-map.md", 5)])
def test_a_tutorial_leads_where_it_says(page: str, commands: int, clone: Path) -> None:
    text = (ROOT / "docs" / "tutorials" / page).read_text()
    assert follow(text, clone) >= commands


def test_what_a_page_promises_and_a_command_does_not_print_is_noticed(tmp_path: Path) -> None:
    page = "```console\n$ echo 1\n2\n```\n"
    with pytest.raises(AssertionError, match="expected '2'"):
        follow(page, tmp_path)


def test_files_and_indented_commands_of_a_page_are_followed_in_order(tmp_path: Path) -> None:
    commands, file = "    $ mkdir in\n    $ cd in\n", "```text title=a.txt\nhello\n```\n"
    page = f"{commands}\n{file}\n```console\n$ cat a.txt\nhello\n```\n"
    assert follow(page, tmp_path) == 3
    assert (tmp_path / "in" / "a.txt").read_text() == "hello\n"


def test_a_command_that_fails_ends_the_page(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="no such thing"):
        follow("```console\n$ echo no such thing && false\n```\n", tmp_path)
