"""The documents name only what exists: files, commands and their options."""

import re
import shlex
from pathlib import Path

import pytest
from tolman.scripts.cli import program as cli

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
COMMAND = re.compile(r"^\s*(?:\$ )?tolman ([a-z].*?)(?:\s{2,}.*|\s+#.*)?$", re.MULTILINE)


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_link_leads_to_a_file(page: Path) -> None:
    targets = [target for target in LINK.findall(page.read_text()) if "://" not in target]
    missing = [target for target in targets if not (page.parent / target).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_command_shown_exists_with_its_options(page: Path) -> None:
    for line in COMMAND.findall(page.read_text()):
        words = shlex.split(line.replace("...", ""), comments=True)
        assert words[0] in cli.COMMANDS, line
        known = cli.build_parser(cli.load(words[0])).options()
        unknown = [word for word in words if word.startswith("--") and word.split("=")[0] not in known]
        assert unknown == [], line


def test_the_pages_that_the_index_names_are_all_there_are() -> None:
    index = (ROOT / "docs" / "index.md").read_text()
    linked = {(ROOT / "docs" / target).resolve() for target in LINK.findall(index) if "://" not in target}
    pages = {page for page in (ROOT / "docs").glob("*.md") if page.name != "index.md"}
    assert pages <= linked, "docs/index.md leaves pages out"


def test_the_places_that_the_architecture_names_exist() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text()
    named = re.findall(r"`((?:files|world|maps|agent|behaviors|plugins|scripts|tools)/[\w/.]*)`", text)
    assert len(named) > 40
    assert [place for place in named if not (ROOT / place).exists()] == []


def test_the_index_of_decisions_names_every_record() -> None:
    folder = ROOT / "docs" / "decisions"
    index = (folder / "index.md").read_text()
    missing = [path.name for path in folder.glob("[0-9]*.md") if f"({path.name})" not in index]
    assert missing == [], "add a line for each to docs/decisions/index.md"


def test_each_promise_of_security_names_a_test_that_exists() -> None:
    page = (ROOT / "docs" / "security.md").read_text()
    tables = [rest.partition("\n\n")[0] for rest in page.split("| promise | held by |")[1:]]
    promises = [line for table in tables for line in table.splitlines() if line.startswith("| ")]
    assert len(promises) > 15
    for line in promises:
        holders = line.rstrip(" |").rpartition(" | ")[2]
        named = re.findall(r"`(tests/[^`]+\.py|python -m [a-z_.]+)", holders)
        assert named, line
        for each in named:
            path = each.removeprefix("python -m ").replace(".", "/") if each.startswith("python") else each
            assert (ROOT / path).exists() or (ROOT / f"{path}.py").exists(), each
