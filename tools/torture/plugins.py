"""Runs missions with plugins that misbehave: each must be contained, or end the run in one line. POSIX only.

The last command to the wheels is zero whatever ended the run, a map that was saved is valid, the JSON on
stdout is JSON, and no process is left.
"""

from __future__ import annotations

import json
import mmap
import os
import signal
import struct
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from tolman.agent import containment
from tolman.maps import validate
from tolman.plugins import discovery, loading
from tolman.scripts.cli import program
from tolman.scripts.session import assembly
from tolman.world.physics.simulated_robot import SimulatedRobot
from tolman.world.robot import WheelCommand

from .misdeeds import Misdeed, misdeeds

MISSION = """
mission: visited by a stranger
steps:
  - explore: {max_nodes: 1}
  - on_failure: {do: {within: {seconds: 1, steps: {do: {behavior: evil}}}}, otherwise: {say: evil is out}}
  - wait: 0.2
  - save: after.tolman
"""
PATIENCE = 60.0
"""Seconds after which a run counts as one that hangs."""
HANG = 0.3
"""Seconds after which the campaign has plugins interrupted, so that it takes less time."""


def plugins(folder: Path, every: int = 1, only: Iterable[str] = ()) -> Counter[str]:
    """Runs each misdeed in the process, where that is promised to hold, and isolated; how it ended.

    every: takes one of so many. only: names, all if there are none.
    """
    result: Counter[str] = Counter()
    names = set(only)
    for number, misdeed in enumerate(misdeeds()):
        if number % every or (names and misdeed.name not in names):
            continue
        for isolated in (False, True) if misdeed.here else (True,):
            ended = _run(misdeed, isolated, folder / f"{number}{'i' if isolated else ''}")
            result[ended] += 1
    return result


def _run(misdeed: Misdeed, isolated: bool, folder: Path) -> str:
    (folder / "plugins").mkdir(parents=True)
    (folder / "plugins" / "evil.py").write_text(misdeed.source)
    (folder / "m.yaml").write_text(MISSION)
    wheels = mmap.mmap(-1, 16)
    child = os.fork()
    if child == 0:
        _in_child(folder, wheels, isolated)
    status = _wait(child)
    where = f"{misdeed.name}, {'isolated' if isolated else 'in the process'}"
    if status is None:
        return f"unclear: hangs: {where}"
    fault = _judge(folder, status, struct.unpack("=dd", wheels[:]))
    if fault:
        return f"unclear: {fault}: {where}"
    return "contained" if status == 0 else f"ended in one line with status {status}"


def _in_child(folder: Path, wheels: mmap.mmap, isolated: bool) -> None:
    """Runs the command as a process of its own does, with every command to the wheels kept."""
    try:
        os.chdir(folder)
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
        for module in (loading, discovery, assembly):
            module.HANG = HANG  # type: ignore[attr-defined]
        loading.IMPORT_TIME, containment.TEXT_TIME = 2.0, HANG
        act = SimulatedRobot.act

        def kept(robot: SimulatedRobot, command: WheelCommand) -> None:
            wheels[:] = struct.pack("=dd", command.left, command.right)
            act(robot, command)

        SimulatedRobot.act = kept  # type: ignore[method-assign, assignment]
        run = ["run", "m.yaml", "--world", "env1", "--global-only", "--json", "--plugins", "plugins"]
        sys.argv = ["tolman", *run, *(["--isolate"] if isolated else [])]
        os._exit(program.main())
    except BaseException as fault:
        os.write(2, f"Traceback: {type(fault).__name__}: {fault}\n".encode())
    os._exit(99)


def _wait(child: int) -> int | None:
    """The exit status, negative for a signal; None for one that had to be killed."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _judge(folder: Path, status: int, wheels: tuple[float, float]) -> str:
    """What is wrong with how a run ended; nothing if all is well."""
    out, err = (folder / "out").read_text(errors="replace"), (folder / "err").read_text(errors="replace")
    if wheels != (0.0, 0.0):
        return f"the last command is {wheels}"
    if "Traceback" in err or "\x1b" in err or max(map(len, err.splitlines()), default=0) > 600:
        return f"stderr holds {err[-200:]!r}"
    if status not in (0, 1, 2, 130):
        return f"status {status}"
    if status and not out and "tolman: " not in err.splitlines()[-1]:
        return f"no line says why: {err[-200:]!r}"
    if out:
        try:
            json.loads(out)
        except ValueError:
            return f"stdout holds {out[:100]!r}"
    saved = folder / "after.tolman"
    if status == 0 and not (saved.exists() and validate(saved).valid):
        return "the map is not valid"
    if (folder / "plugins" / "evil.py.written").exists() or not (folder / "plugins" / "evil.py").exists():
        return "an isolated plugin wrote files"
    return "processes are left" if _left(folder) else ""


def _left(folder: Path) -> list[int]:
    """Processes of a run that go on, and what plugins start."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_bytes()
        except OSError:
            continue
        if int(process.name) != os.getpid() and (str(folder).encode() in command or b"\x003117" in command):
            found.append(int(process.name))
    return found
