"""What is installed: the wheel holds everything, runs alone, and loads nothing heavy by itself."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FRONT = "tolman"
"""The folder that is the package itself; the others are installed below it."""
FOLDERS = ("files", "world", "maps", "agent", "behaviors", "plugins", "scripts")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy of the sources so that nothing is left in the checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    sources = folder / "sources"
    sources.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    for name in (FRONT, *FOLDERS):
        shutil.copytree(ROOT / name, sources / name, ignore=shutil.ignore_patterns("__pycache__"))
    program = "import sys; from setuptools.build_meta import build_wheel; print(build_wheel(sys.argv[1]))"
    subprocess.run(
        [sys.executable, "-c", program, str(folder)],
        cwd=sources,
        capture_output=True,
        check=True,
        timeout=120,
    )
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a new environment that has the wheel, and our dependencies but not our sources."""
    pytest.importorskip("pip", reason="this environment was made without pip")
    folder = tmp_path_factory.mktemp("installed")
    venv.EnvBuilder(with_pip=False, symlinks=os.name != "nt").create(folder)
    python = folder / "bin" / "python"
    place = Path(
        subprocess.run(
            [python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])"],
            capture_output=True, text=True, check=True,
        ).stdout.strip()
    )  # fmt: skip
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(python),
        "install",
        "--no-deps",
        "--quiet",
        str(wheel),
    ]
    subprocess.run(pip, check=True, capture_output=True, timeout=120)
    for entry in filter(None, sys.path):
        if entry.endswith(("site-packages", "dist-packages")):  # dependencies, without the editable finder
            (place / "dependencies.pth").write_text(entry + "\n")
    return python


@pytest.mark.e2e
def test_the_wheel_holds_every_module_and_data_file(wheel: Path) -> None:
    within = set(zipfile.ZipFile(wheel).namelist())
    for folder in FOLDERS:
        for path in [*(ROOT / folder).glob("*"), *(ROOT / "scripts" / "missions").glob("*")]:
            if path.suffix in {".py", ".yaml", ".json"} or path.name == "py.typed":
                assert f"tolman/{path.relative_to(ROOT)}" in within
    assert {f"tolman/{path.name}" for path in (ROOT / FRONT).glob("[!.]*.*")} <= within
    assert not [name for name in within if name.startswith(("tests/", "typings/"))]


@pytest.mark.e2e
def test_the_wheel_alone_runs_the_command(installed: Path, tmp_path: Path) -> None:
    command = installed.parent / "tolman"
    where = "import tolman.world; print(tolman.world.__file__)"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    found = subprocess.run(
        [installed, "-c", where], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert str(installed.parent.parent) in found.stdout
    listed = subprocess.run(
        [command, "worlds"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60
    )
    assert (listed.returncode, listed.stderr) == (0, "")
    assert "env1" in listed.stdout.split()


def test_every_folder_is_installed_and_seen_by_static_tools() -> None:
    packages = {FRONT}
    for folder in FOLDERS:
        inside = [path.parent.relative_to(ROOT) for path in (ROOT / folder).rglob("__init__.py")]
        packages |= {".".join(["tolman", *path.parts]) for path in inside}
    assert set(PROJECT["tool"]["setuptools"]["packages"]) == packages
    for folder in FOLDERS:
        assert (ROOT / "typings" / "tolman" / folder).resolve() == ROOT / folder
    for path in (ROOT / FRONT).glob("*.py*"):
        assert (ROOT / "typings" / "tolman" / path.name).resolve() == path


def test_every_requirement_is_pinned_and_no_index_is_named() -> None:
    text = (ROOT / "constraints.txt").read_text()
    pinned = {re.split(r"[=<>; ]", line)[0].lower() for line in text.splitlines() if line[:1].isalpha()}
    asked = [*PROJECT["project"]["dependencies"]]
    for extra in ("test", "dev"):  # what scripts/bootstrap.py installs
        asked += PROJECT["project"]["optional-dependencies"][extra]
    names = {re.split(r"[\[=<>; ]", requirement)[0].lower() for requirement in asked} - {"tolman"}
    assert names <= pinned
    assert "://" not in text
    assert "--" not in text


def test_every_entry_point_loads_what_it_names() -> None:
    from importlib.metadata import entry_points

    for group in PROJECT["project"]["entry-points"]:
        ours = [point for point in entry_points(group=group) if point.value.startswith("tolman.")]
        assert ours, f"nothing is installed for {group}"
        for point in ours:
            point.load()


@pytest.mark.parametrize("package", FOLDERS)
def test_importing_a_package_loads_nothing_heavy(package: str) -> None:
    program = (
        f"import sys, tolman.{package}\n"
        "print([name for name in ('dartpy', 'embreex', 'matplotlib', 'yaml') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
