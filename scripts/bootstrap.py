"""Sets tolman up in `.venv`, once, and runs a target there: `python3 scripts/bootstrap.py TARGET [ARGS]`.

Standard library alone, and written so that a Python too old for tolman can still read it and say so. `make`
only forwards to this file. Exit status: the target's own; 2 when the machine lacks something, with one line
that says what and how to get it.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
READY = VENV / "tolman-ready.json"
VERSIONS = ((3, 14), (3, 13), (3, 12), (3, 11))
OLDEST_SQLITE = (3, 37, 0)
LIBRARIES = {"libGL.so.1": "libgl1", "libX11.so.6": "libx11-6"}
PROBE = """
import importlib.util as find, json, sys
try:
    import sqlite3
    sqlite = sqlite3.sqlite_version_info
except ImportError:
    sqlite = (0, 0, 0)
print(json.dumps({"version": sys.version_info[:3], "sqlite": sqlite, "path": sys.executable,
    "implementation": sys.implementation.name, "venv": find.find_spec("venv") is not None,
    "ensurepip": find.find_spec("ensurepip") is not None, "pip": find.find_spec("pip") is not None}))
"""
KIT = "kit"
"""The extra that every set-up has: what the tutorials use."""
PYTEST = ["-m", "pytest", "-n", "2"]
FAST = ["-q", "-m", "not slow and not e2e", "--hypothesis-profile=quick"]
LINT = [
    ["-m", "ruff", "check", "."],
    ["-m", "ruff", "format", "--check", "."],
    ["-m", "mypy"],
    ["-m", "tools.contracts"],
]
TARGETS = {
    "setup": (KIT, []),
    "demo": (KIT, [["-m", "tolman.scripts.demo"]]),
    "test": ("test", [PYTEST]),
    "lint": ("dev", LINT),
    "check": ("dev", [*LINT, [*PYTEST, *FAST]]),
    "docs": ("docs", [["-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", "out/site"]]),
    "matrix": ("test", [["-m", "tools.matrix"]]),
    "bench": (
        "bench",
        [
            ["-m", "benchmarks.bench"],
            ["-m", "benchmarks.tick"],
            ["-m", "benchmarks.maps"],
        ],
    ),
    "torture": (KIT, [["-m", "tools.torture.worlds"], ["-m", "tools.torture", "all"]]),
    "format": ("dev", [["-m", "ruff", "check", "--fix", "."], ["-m", "ruff", "format", "."]]),
}
"""Target -> (the extra of pyproject.toml it needs, the arguments of each Python process to run in turn)."""


class SetupError(Exception):
    """The machine lacks something; the message is one line that says what and what to do."""


def check_libraries() -> None:
    """Loads the system libraries that DART's wheel needs, before anything is downloaded."""
    if not sys.platform.startswith("linux"):
        return
    missing = []
    for library in LIBRARIES:
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(library)
    if not missing:
        return
    if shutil.which("dnf"):
        command = "dnf install mesa-libGL libX11"
    else:
        command = "apt-get update && apt-get install -y " + " ".join(LIBRARIES[name] for name in missing)
    raise SetupError("missing system libraries {}; install them with: {}".format(", ".join(missing), command))


def probe(executable: str) -> dict[str, Any] | None:
    """What the interpreter `executable` offers, or None if it does not run."""
    try:
        # -E and a neutral folder: nothing of PYTHONPATH or of this checkout may shadow the standard library.
        done = subprocess.run(
            [executable, "-E", "-c", PROBE],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=60,
            cwd="/",
        )
        return json.loads(done.stdout.decode()) if done.returncode == 0 else None
    except (OSError, ValueError, subprocess.SubprocessError):
        return None


def candidates() -> list[str]:
    """Interpreters to try: $PYTHON, the one running, then those on PATH and pyenv's, newest first."""
    asked = os.environ.get("PYTHON")
    if asked:
        return [asked]
    found = [sys.executable]
    for version in VERSIONS:
        name = "python{}.{}".format(*version)
        on_path = shutil.which(name)
        if on_path:
            found.append(on_path)
        pyenv = Path(os.environ.get("PYENV_ROOT", str(Path.home() / ".pyenv"))) / "versions"
        found.extend(
            str(path) for path in sorted(pyenv.glob("{}.{}.*/bin/python".format(*version)), reverse=True)
        )
    return list(dict.fromkeys(found))


def fault_of(python: dict[str, Any]) -> str:
    """Why this interpreter will not do, or nothing."""
    version = tuple(python["version"][:2])
    if python["implementation"] != "cpython":
        return "is not CPython"
    if version not in VERSIONS:
        return "is Python {}.{}".format(*version)
    if tuple(python["sqlite"]) < OLDEST_SQLITE:
        return "has SQLite {}.{}.{} (3.37 or newer needed)".format(*python["sqlite"])
    if not python["venv"]:
        return "lacks the module venv (apt-get install python3-venv)"
    if not python["ensurepip"] and not python["pip"]:
        return "has neither ensurepip nor pip (apt-get update && apt-get install -y python3-venv)"
    return ""


def find_python() -> dict[str, Any]:
    """The first interpreter that can run tolman, as `probe` describes it.

    Raises: SetupError if there is none, with the reason for the nearest miss.
    """
    faults = []
    for executable in candidates():
        python = probe(executable)
        fault = fault_of(python) if python else "does not run"
        if python and not fault:
            return python
        faults.append((not (python and tuple(python["version"][:2]) in VERSIONS), f"{executable} {fault}"))
    raise SetupError(
        f"needs CPython 3.11 to 3.14 with SQLite 3.37 or newer; {min(faults)[1]}; "
        "set PYTHON=/path/to/python to name another"
    )


def fingerprint(python: dict[str, Any]) -> str:
    """Changes when anything does that the installed environment depends on."""
    digest = hashlib.sha256()
    for part in (ROOT / "pyproject.toml", ROOT / "constraints.txt", Path(__file__)):
        digest.update(part.read_bytes() + b"\0")
    digest.update(json.dumps([str(ROOT), python["version"], platform.machine()]).encode())
    return digest.hexdigest()


def venv_python() -> Path:
    """The environment's own interpreter."""
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def installed_extras(mark: str) -> set[str]:
    """The extras of a finished set-up with this fingerprint; empty when there is none."""
    try:
        ready = json.loads(READY.read_text())
    except (OSError, ValueError):
        return set()
    return set(ready["extras"]) if ready.get("mark") == mark and venv_python().exists() else set()


def call(command: list[str], what: str) -> None:
    """Runs one step of the set-up; its output goes to stderr."""
    try:
        status = subprocess.run(command, cwd=str(ROOT), stdout=sys.stderr.fileno()).returncode
    except OSError as error:
        raise SetupError(f"cannot {what}: {error}") from error
    if status != 0:
        raise SetupError(f"cannot {what}: the command above ended with status {status}")


def make_environment(python: dict[str, Any]) -> None:
    """Makes `.venv` anew if the one that stands was made by another Python or for another place."""
    usable = probe(str(venv_python())) if venv_python().exists() else None
    if usable and usable["version"] == python["version"] and Path(usable["path"]).parent.parent == VENV:
        return
    if VENV.exists():
        shutil.rmtree(str(VENV))
    extra = [] if python["ensurepip"] else ["--without-pip"]
    call([python["path"], "-m", "venv", *extra, str(VENV)], "make .venv")


def install(python: dict[str, Any], extras: set[str]) -> None:
    """Installs tolman, editable, with its pinned dependencies into `.venv`."""
    target = str(ROOT) + ("[{}]".format(",".join(sorted(extras))) if extras else "")
    options = ["--disable-pip-version-check", "--quiet", "-c", str(ROOT / "constraints.txt"), "-e", target]
    own = probe(str(venv_python()))
    if own and own["pip"]:
        call([str(venv_python()), "-m", "pip", "install", *options], "install tolman")
    else:  # made without ensurepip: the outer Python's pip installs into it
        call(
            [python["path"], "-m", "pip", "--python", str(venv_python()), "install", *options],
            "install tolman",
        )


def set_up(extra: str) -> None:
    """Brings `.venv` to what the target needs; does nothing if a finished set-up stands there.

    Raises: SetupError.
    """
    check_libraries()
    python = find_python()
    mark = fingerprint(python)
    done = installed_extras(mark)
    wanted = {KIT, extra}
    covered = {"test"} if done & {"dev", "bench"} else set()
    if wanted <= done | covered:
        return
    print("tolman: setting up .venv with Python {}.{}.{} (once)".format(*python["version"]), file=sys.stderr)
    if READY.exists():
        READY.unlink()
    make_environment(python)
    install(python, wanted | done)
    READY.write_text(json.dumps({"mark": mark, "extras": sorted(wanted | done)}) + "\n")


def run(target: str, arguments: list[str]) -> int:
    """Runs all of the target's processes, in turn; returns the first exit status that is not 0."""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", PYTHONUNBUFFERED="1")
    environment.pop("PYTHONPATH", None)
    statuses = []
    for command in TARGETS[target][1]:
        print("tolman: python " + " ".join(command + arguments)[:100], file=sys.stderr, flush=True)
        full = [str(venv_python()), *command, *arguments]
        statuses.append(subprocess.run(full, cwd=str(ROOT), env=environment).returncode)
    failed = [status for status in statuses if status != 0]
    return 0 if not failed else failed[0] if failed[0] > 0 else 128 - failed[0]


def main(arguments: list[str]) -> int:
    """Runs the target that the command line names."""
    if not arguments or arguments[0] not in TARGETS:
        print("usage: python3 scripts/bootstrap.py {} [ARGUMENTS]".format("|".join(TARGETS)), file=sys.stderr)
        return 0 if arguments[:1] in (["-h"], ["--help"]) else 2
    programs = TARGETS[arguments[0]][1]
    if len(arguments) > 1 and len(programs) != 1:
        names = ", ".join(" ".join(program[:2]) for program in programs) or "none"
        what = f"{arguments[0]} takes no arguments; its programs do, with .venv/bin/python"
        print(f"tolman: {what}: {names}", file=sys.stderr)
        return 2
    try:
        set_up(TARGETS[arguments[0]][0])
        return run(arguments[0], arguments[1:])
    except SetupError as error:
        print(f"tolman: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
