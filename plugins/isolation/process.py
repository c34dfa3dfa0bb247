"""Starts the subprocess of an isolated plugin, talks with it, and ends it with all that it has started."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...agent.containment import describe
from ...files.messages import printable
from ..errors import BrokenPluginError, IsolationError
from ..loading import spec_of
from .wire import Channel, Kind

START_TIMEOUT = 30.0
"""Seconds that a subprocess may take to import its plugin."""
LONGEST = 200
"""Characters of a text that a subprocess says of itself."""
_SAFE = ("PATH", "HOME", "LANG", "TZ", "TMPDIR", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
"""Variables of the environment that a plugin may see, besides LC_ and PYTHON ones: no keys, no tokens."""


class Subprocess:
    """One running subprocess and its channel; killed when it is dropped.

    hello: what it says that it holds, as JSON.
    """

    def __init__(self, spec: Mapping[str, Any], module: str = "child", timeout: float | None = None) -> None:
        """Starts it and waits for what it says it is. Raises: BrokenPluginError, IsolationError."""
        to_child, child_writes = os.pipe(), os.pipe()
        child = (to_child[0], child_writes[1])
        arguments = [sys.executable, "-P", "-m", f"{__package__}.{module}", json.dumps(spec)]
        self._process = subprocess.Popen(
            [*arguments, *map(str, child), str(os.getpid())],
            pass_fds=child,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=_environment(),
            start_new_session=True,
        )
        for descriptor in child:
            os.close(descriptor)
        self.channel = Channel(child_writes[0], to_child[1])
        self._finalizer = weakref.finalize(self, _end, self._process, self.channel)
        try:
            kind, body = self.receive(START_TIMEOUT if timeout is None else timeout)
        except IsolationError as fault:
            raise BrokenPluginError(f"{_what(spec)}: {fault}") from fault
        try:
            if kind != Kind.HELLO:
                raise ValueError(printable(body.decode(errors="replace")[: 2 * LONGEST]))
            self.hello: Any = json.loads(body)
        except (ValueError, RecursionError) as fault:
            self.kill()
            text, known = describe(fault, kind=False), str(spec.get("file"))
            raise BrokenPluginError(text if known in text else f"{_what(spec)}: {text}") from fault

    def receive(self, timeout: float) -> tuple[int, bytes]:
        """The next message. Raises: IsolationError, saying how the process ended if it did."""
        try:
            return self.channel.receive(time.monotonic() + timeout)
        except IsolationError as fault:
            self.kill()
            code = self._process.returncode
            how = "it ran too long" if code == -signal.SIGXCPU else f"exit status {code}"
            raise IsolationError(f"{fault} ({how})") from fault

    def kill(self) -> None:
        """Ends it now, with all processes that it started. More than once does no harm."""
        self._finalizer()


def _what(spec: Mapping[str, Any]) -> str:
    return f"{spec.get('file') or spec.get('entry')}: in its subprocess"


def _environment() -> dict[str, str]:
    kept = {
        name: value
        for name, value in os.environ.items()
        if name in _SAFE or name.startswith(("LC_", "PYTHON"))
    }
    return kept | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}


def _end(process: subprocess.Popen[bytes], channel: Channel) -> None:
    """Whoever ended by itself keeps its own status; who hangs is killed, and so is what it left behind."""
    deadline = time.monotonic() + 0.02
    while time.monotonic() < deadline and not _ended(process.pid):
        time.sleep(0.001)
    with contextlib.suppress(OSError):  # before it is waited for: until then the group's number is its own
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    channel.close()


def _ended(number: int) -> bool:
    try:
        return os.waitid(os.P_PID, number, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def describe_file(path: Path) -> list[dict[str, Any]]:
    """What a plugin file holds, found out in a subprocess: a mapping for each plugin.

    Raises: BrokenPluginError.
    """
    child = Subprocess(spec_of(path))
    child.kill()
    if not isinstance(child.hello, list) or not all(isinstance(each, dict) for each in child.hello):
        raise BrokenPluginError(f"{path}: its subprocess says nothing sensible")
    return child.hello
