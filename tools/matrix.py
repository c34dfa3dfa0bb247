"""Builds the wheel once and runs the tests against it on every supported Python that this machine has.

`python -m tools.matrix [3.11 3.13]`. Each Python gets an environment of its own under `out/matrix`, with the
pinned versions; sources are not on its path, so that only what the wheel holds is tested. Pythons that are
not here are named. Exit status: 0 where all that ran passed, 1 otherwise, 2 if none could be run.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from tolman.scripts.bootstrap import ROOT, VERSIONS, candidates, fault_of, probe

OUT = ROOT / "out" / "matrix"
BESIDE = ("tests", "tools", "benchmarks", "docs", "README.md", "pyproject.toml", "constraints.txt")
"""What the tests need besides the wheel."""
OF_THE_CHECKOUT = (
    "tests/test_packaging.py",
    "tests/tools/test_structure.py",
    "tests/scripts/test_bootstrap.py",
)
"""Tests of the checkout itself, which the wheel does not hold."""


def pythons() -> dict[str, str]:
    """Version such as "3.12" -> the interpreter of it that would be used here."""
    found: dict[str, str] = {}
    for executable in candidates():
        known = probe(executable)
        if known and not fault_of(known):
            found.setdefault("{}.{}".format(*known["version"]), executable)
    return found


def build() -> Path:
    """The wheel, built from the checkout."""
    wheels = OUT / "wheel"
    shutil.rmtree(wheels, ignore_errors=True)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--wheel-dir", str(wheels), str(ROOT)], check=True)
    return next(wheels.glob("*.whl"))


def test_on(version: str, executable: str, wheel: Path, arguments: list[str]) -> bool:
    """Whether the tests pass on this Python with the wheel installed."""
    folder = OUT / version
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([executable, "-m", "venv", str(folder / "venv")], check=True)
    python = str(folder / "venv" / "bin" / "python")
    target = f"tolman[test] @ {wheel.as_uri()}"
    pins = ["-c", str(ROOT / "constraints.txt")]
    subprocess.run([python, "-m", "pip", "install", "--quiet", *pins, target], check=True)
    for name in BESIDE:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / name)
    shutil.copytree(ROOT / "scripts" / "missions", folder / "scripts" / "missions")
    left_out = [f"--ignore=tests/{name}" for name in OF_THE_CHECKOUT]
    command = [python, "-m", "pytest", "-n", "2", "-q", *left_out, *arguments]
    return subprocess.run(command, cwd=folder, check=False).returncode == 0


def main() -> int:
    """Runs the matrix."""
    parser = argparse.ArgumentParser(prog="python -m tools.matrix", description=__doc__)
    parser.add_argument("versions", nargs="*", metavar="VERSION", help="only these, such as 3.12")
    parser.add_argument("--pytest", action="append", default=[], help="a further argument of pytest")
    options = parser.parse_args()
    known = ["{}.{}".format(*version) for version in sorted(VERSIONS)]
    here = pythons()
    chosen = [version for version in options.versions or known if version in here]
    absent = [version for version in options.versions or known if version not in here]
    if not chosen:
        print(f"matrix: none of {', '.join(absent)} is on this machine", file=sys.stderr)
        return 2
    wheel = build()
    passed = {version: test_on(version, here[version], wheel, options.pytest) for version in chosen}
    for version, well in passed.items():
        print(f"Python {version}: {'passed' if well else 'FAILED'}")
    for version in absent:
        print(f"Python {version}: not on this machine")
    return 0 if all(passed.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
