"""`import tolman`: everything people use, and nothing loaded before it is."""

import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tolman

DOCS = Path(__file__).parent.parent / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def loaded_by(program: str) -> set[str]:
    """The modules that a program of a line or two leaves loaded in a process of its own."""
    command = f"{program}\nimport sys; print('\\n' + ' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True)
    return set(done.stdout.rpartition("\n\n")[2].split())


NAMES: list[str] = vars(tolman)["__all__"]


@pytest.mark.parametrize("name", NAMES)
def test_everything_that_is_promised_is_there_and_explains_itself(name: str) -> None:
    value = getattr(tolman, name)
    assert isinstance(value, str) or inspect.getdoc(value)


def test_help_tells_what_one_does_with_it() -> None:
    text = pydoc.plain(pydoc.render_doc(tolman))
    for word in ("Simulation", "HybridMap", "Behavior", "simulation.step()", "tolman.plugins.testing"):
        assert word in text


def test_importing_it_loads_nothing_of_ours_or_of_others() -> None:
    loaded = loaded_by("import tolman")
    assert not loaded & {"numpy", "yaml", "networkx", "dartpy", "tolman.world", "tolman.agent", "tolman.maps"}


@pytest.mark.parametrize(
    ("arguments", "absent"),
    [
        ("--help", {"numpy", "yaml", "networkx", "tolman.world"}),
        (
            "worlds",
            {"dartpy", "networkx", "mcap", "transitions", "matplotlib", "tolman.agent", "tolman.maps"},
        ),
    ],
)
def test_lists_of_names_load_no_more_than_they_need(arguments: str, absent: set[str]) -> None:
    program = f"from tolman.scripts.cli import main\nimport sys; sys.argv = ['tolman', '{arguments}']\n"
    ended = "try: main()\nexcept SystemExit: pass"
    assert not loaded_by(program + ended) & absent


def test_a_name_that_is_not_there_is_told() -> None:
    with pytest.raises(AttributeError, match="Simulaton"):
        tolman.Simulaton  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.slow
def test_the_page_on_python_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = BLOCK.findall((DOCS / "python.md").read_text())
    assert len(blocks) >= 5
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
