"""Work in a child process, so that whatever becomes of it is only told. POSIX only."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable


def in_child(
    work: Callable[[Callable[[bytes], object]], object], kill_after: float | None = None
) -> tuple[bytes, int]:
    """Has a child do some work; what it told by the function it is given, and the signal that ended it or 0.

    kill_after: wall-clock seconds after which it is killed, so that it can clear up nothing.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            work(lambda text: os.write(writing, text))
        finally:
            os._exit(0)
    os.close(writing)
    if kill_after is not None:
        time.sleep(kill_after)
        os.kill(child, signal.SIGKILL)
    with os.fdopen(reading, "rb") as lines:
        told = lines.read()
    status = os.waitpid(child, 0)[1]
    return told, os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
