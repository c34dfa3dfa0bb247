"""The set-up script: which Python it takes, what it says when something is missing, when it sets up again."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tolman.scripts import bootstrap
from tolman.scripts.bootstrap import SetupError

GOOD: dict[str, Any] = {
    "version": [3, 12, 1],
    "sqlite": [3, 40, 1],
    "path": "/usr/bin/python3",
    "implementation": "cpython",
    "venv": True,
    "ensurepip": True,
    "pip": True,
}


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({}, ""),
        ({"ensurepip": False}, ""),
        ({"pip": False}, ""),
        ({"version": [3, 10, 13]}, "is Python 3.10"),
        ({"version": [3, 15, 0]}, "is Python 3.15"),
        ({"sqlite": [3, 36, 0]}, "has SQLite 3.36.0 (3.37 or newer needed)"),
        ({"implementation": "pypy"}, "is not CPython"),
        ({"venv": False}, "lacks the module venv (apt-get install python3-venv)"),
    ],
)
def test_a_python_is_taken_or_said_why_not(change: dict[str, Any], fault: str) -> None:
    assert bootstrap.fault_of({**GOOD, **change}) == fault


def test_without_ensurepip_and_pip_the_package_is_named() -> None:
    assert "install -y python3-venv" in bootstrap.fault_of({**GOOD, "ensurepip": False, "pip": False})


def test_the_running_python_passes() -> None:
    python = bootstrap.probe(sys.executable)
    assert python is not None
    assert bootstrap.fault_of(python) == ""


def test_a_python_that_does_not_run_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHON", "/nowhere/python")
    with pytest.raises(SetupError, match="/nowhere/python does not run"):
        bootstrap.find_python()


def test_the_nearest_miss_is_the_one_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    found = {"old": {**GOOD, "version": [3, 9, 2]}, "near": {**GOOD, "sqlite": [3, 34, 0]}, "gone": None}
    monkeypatch.setattr(bootstrap, "candidates", lambda: list(found))
    monkeypatch.setattr(bootstrap, "probe", found.__getitem__)
    with pytest.raises(SetupError, match=r"near has SQLite 3\.34\.0"):
        bootstrap.find_python()


def test_missing_libraries_are_named_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    def load(name: str) -> None:
        if name == "libGL.so.1":
            raise OSError(name)

    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("ctypes.CDLL", load)
    monkeypatch.setattr("shutil.which", {"apt-get": "/usr/bin/apt-get"}.get)
    with pytest.raises(SetupError, match=r"libraries libGL\.so\.1;.*apt-get install -y libgl1$"):
        bootstrap.check_libraries()


def test_a_finished_set_up_is_known_by_its_mark(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(bootstrap, "VENV", tmp_path)
    monkeypatch.setattr(bootstrap, "READY", tmp_path / "ready.json")
    assert bootstrap.installed_extras("mark") == set()
    bootstrap.READY.write_text(json.dumps({"mark": "mark", "extras": ["kit", "test"]}))
    assert bootstrap.installed_extras("mark") == set(), "without an interpreter nothing is finished"
    bootstrap.venv_python().parent.mkdir()
    bootstrap.venv_python().touch()
    assert bootstrap.installed_extras("mark") == {"kit", "test"}
    assert bootstrap.installed_extras("another") == set()
    bootstrap.READY.write_text("{")
    assert bootstrap.installed_extras("mark") == set()


def test_the_mark_changes_with_the_python() -> None:
    assert bootstrap.fingerprint(GOOD) == bootstrap.fingerprint({**GOOD, "path": "/opt/python"})
    assert bootstrap.fingerprint(GOOD) != bootstrap.fingerprint({**GOOD, "version": [3, 13, 0]})


def test_make_knows_the_same_targets() -> None:
    makefile = (bootstrap.ROOT / "Makefile").read_text()
    phony = re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert phony is not None
    assert set(phony[1].split()) == set(bootstrap.TARGETS)


def test_an_unknown_target_lists_the_known_ones() -> None:
    done = subprocess.run(
        [sys.executable, bootstrap.__file__, "tset"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "demo|test" in done.stderr
    assert done.stderr.count("\n") == 1


def test_arguments_for_several_programs_are_refused_with_their_names(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bootstrap, "set_up", lambda extra: pytest.fail("nothing must be installed"))
    assert bootstrap.main(["bench", "--smoke"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "-m benchmarks.bench" in said


@pytest.mark.parametrize(
    ("done", "extra", "installs"),
    [
        ({"kit", "dev"}, "test", False),
        ({"kit", "dev"}, "bench", True),
        ({"kit", "bench"}, "test", False),
        ({"kit"}, "test", True),
        ({"kit"}, "kit", False),
    ],
)
def test_what_is_installed_already_is_not_installed_again(
    done: set[str], extra: str, installs: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    installed: list[set[str]] = []
    for name, stand_in in (
        ("check_libraries", lambda: None),
        ("find_python", lambda: GOOD),
        ("fingerprint", lambda python: "mark"),
        ("installed_extras", lambda mark: done),
        ("make_environment", lambda python: None),
        ("install", lambda python, extras: installed.append(extras)),
        ("READY", tmp_path / "ready.json"),
    ):
        monkeypatch.setattr(bootstrap, name, stand_in)
    bootstrap.set_up(extra)
    assert bool(installed) == installs
    assert all(extra in extras for extras in installed)
