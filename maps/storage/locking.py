"""One writer a map file: an advisory lock on a file beside it, dropped when the process dies."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from ..errors import MapFileLockedError

LOCK_SUFFIX = "-lock"


def sibling(path: Path, ending: str) -> Path:
    """The file beside `path` with that ending added to its name."""
    return path.with_name(path.name + ending)


class Lock:
    """A held lock. The file beside the map stays after a kill; the lock on it does not."""

    def __init__(self, path: Path, descriptor: int) -> None:
        """Not to be called: see `acquire`."""
        self._path = path
        self._descriptor: int | None = descriptor

    @classmethod
    def acquire(cls, target: Path) -> Self:
        """Locks the map file `target`. Raises: MapFileLockedError, OSError."""
        path = sibling(target, LOCK_SUFFIX)
        for _ in range(10):
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
            try:
                _lock(descriptor)
                if path.exists() and os.path.samestat(os.fstat(descriptor), path.stat()):
                    return cls(path, descriptor)
            except BlockingIOError:
                os.close(descriptor)
                raise MapFileLockedError(f"{target}: another process is writing this map") from None
            except FileNotFoundError:
                pass  # the one who had it removed it between our two looks
            os.close(descriptor)
        raise MapFileLockedError(f"{target}: its lock {path.name} keeps changing hands")

    @classmethod
    @contextmanager
    def held(cls, target: Path) -> Iterator[None]:
        """Holds the lock of `target` for a block. Raises: MapFileLockedError, OSError."""
        lock = cls.acquire(target)
        try:
            yield
        finally:
            lock.release()

    def release(self) -> None:
        """Removes the lock. Twice does nothing."""
        if self._descriptor is not None:
            self._path.unlink(missing_ok=True)
            os.close(self._descriptor)
            self._descriptor = None


def _lock(descriptor: int) -> None:
    """Raises: BlockingIOError when somebody else has it."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError as error:
            raise BlockingIOError(str(error)) from None
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
