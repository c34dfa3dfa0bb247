"""Work in a child process, so that whatever becomes of it is only told. POSIX only."""

from __future__ import annotations

import os
import resource
import signal
import time
from collections import Counter
from collections.abc import Callable
from functools import partial

BATCH = 250
"""Pieces of work that one child does: a death costs no more than those."""
MEMORY_LIMIT_MB = 500
PATIENCE = 30
"""Seconds after which one piece of work counts as a hang."""


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


def counted(count: int, work: Callable[[int], str]) -> Counter[str]:
    """Has children do the work of each number below `count`; how often it ended how, as it says itself.

    Counted besides: hangs, crashes, batches that ended early, and whether a child took too much memory.
    """
    result: Counter[str] = Counter()
    for first in range(0, count, BATCH):
        numbers = range(first, min(first + BATCH, count))
        told, killed = in_child(partial(_batch, numbers, work))
        endings = told.decode().splitlines()
        result += Counter(endings)
        result["ended the campaign"] += len(endings) < len(numbers)
        if killed:
            result["hangs" if killed == signal.SIGALRM else "crashes"] += 1
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024
    result["peak memory of a reader, MB"] = peak
    result["over the memory limit"] = int(peak > MEMORY_LIMIT_MB)
    return result


def _batch(numbers: range, work: Callable[[int], str], tell: Callable[[bytes], object]) -> None:
    signal.signal(signal.SIGALRM, signal.SIG_DFL)  # so that an alarm kills, also out of C code
    for number in numbers:
        signal.alarm(PATIENCE)
        tell(f"{work(number)}\n".encode())
