"""The gate for all files that are written: whole or not at all, and never into what is no regular file.

A file grows under a name that nobody can guess, in the folder of its target, made exclusively, and takes the
target's place when all of it is on the disk. A link is followed to its end if that is a regular file: the
file at the end is replaced, and the link stays. Other links, devices, pipes and folders are refused.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .messages import FileError, printable

_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
_GROWING = os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK)
"""What file systems say that know no hard links."""


class TargetExistsError(FileError):
    """Something stands where a file is to be written, and to replace it was not asked for."""


class WriteError(FileError, RuntimeError):
    """The disk did not take a file; what was there before is untouched."""


def check_target(path: Path, *, replace: bool, hint: str = "--force replaces it") -> Path:
    """Where a file is to be written: `path`, or where the link of that name ends. Nothing is changed.

    hint: what a message about an existing file ends with.

    Raises: TargetExistsError without `replace`, FileError for a missing or locked folder, or for what is no
    regular file, with `replace` too.
    """
    shown = printable(str(path))
    try:
        target = path.resolve() if path.is_symlink() else path
        found = _mode(target)
        if found is None and target != path:
            raise FileError(f"{shown}: a link to {printable(str(target))}, where there is nothing")
        _check_folder(target.parent, shown)
    except ValueError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{shown!r}: no file can have this name") from None
    except (OSError, RuntimeError) as error:  # a circle of links, a name too long
        raise FileError(f"{shown}: cannot be written: {getattr(error, 'strerror', error)}") from None
    if found is not None:
        _check_found(target, found, shown, replace, hint)
    return target


def _mode(path: Path) -> int | None:
    try:
        return os.lstat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return None


def _check_folder(folder: Path, shown: str) -> None:
    if not folder.is_dir():
        raise FileError(f"{shown}: there is no folder {printable(str(folder))}; make it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(f"{shown}: no permission to write in {printable(str(folder))}")


def _check_found(target: Path, mode: int, shown: str, replace: bool, hint: str) -> None:
    if stat.S_ISDIR(mode):
        raise FileError(f"{shown} is a folder; name a file in it")
    if not stat.S_ISREG(mode):
        raise FileError(f"{shown} is a device, a pipe or a socket; name a regular file")
    if not replace:
        raise TargetExistsError(f"{shown} exists; {hint}")
    if not os.access(target, os.W_OK):
        raise FileError(f"{shown}: no permission to replace it")


@contextlib.contextmanager
def atomic_path(path: Path, *, replace: bool = False) -> Iterator[Path]:
    """A new, empty file to be written by its name; it becomes `path` when the block ends well, else nothing.

    Raises: as `check_target`; WriteError when the disk does not take it.
    """
    target = check_target(path, replace=replace)
    part = target.with_name(f".tolman-{secrets.token_hex(8)}.part")
    try:
        with _one_line(path):
            os.close(os.open(part, _NEW, 0o666))
        yield part
        with _one_line(path):
            _put(part, check_target(path, replace=replace), replace)
    finally:
        part.unlink(missing_ok=True)


@contextlib.contextmanager
def atomic_file(path: Path, *, replace: bool = False) -> Iterator[BinaryIO]:
    """A new file, open for bytes; it becomes `path` when the block ends well, else nothing is left of it.

    Raises: as `atomic_path`.
    """
    flags = os.O_WRONLY | os.O_NOFOLLOW | os.O_CLOEXEC
    with (
        atomic_path(path, replace=replace) as part,
        _one_line(path),
        os.fdopen(os.open(part, flags), "wb") as file,
    ):
        yield file


def write_bytes(path: Path, data: bytes, *, replace: bool = False) -> None:
    """Writes a whole file, durably. Raises: as `atomic_path`."""
    with atomic_file(path, replace=replace) as file:
        file.write(data)


def write_text(path: Path, text: str, *, replace: bool = False) -> None:
    """Writes a whole file of UTF-8 text, durably. Raises: as `atomic_path`."""
    write_bytes(path, text.encode("utf-8"), replace=replace)


def open_growing(path: Path, *, replace: bool = False, append: bool = False) -> BinaryIO:
    """Opens a file that is to be of use while it grows, such as a journal. append: after what is in it.

    Raises: as `check_target`; WriteError.
    """
    target = check_target(path, replace=replace or append)
    with _one_line(path):
        descriptor = os.open(target, _GROWING | (os.O_APPEND if append else 0), 0o666)
    try:
        _check_found(target, os.fstat(descriptor).st_mode, printable(str(path)), True, "")
        if not append:
            os.ftruncate(descriptor, 0)
        return os.fdopen(descriptor, "ab" if append else "wb")
    except BaseException:
        os.close(descriptor)
        raise


def sync_folder(path: Path) -> None:
    """Makes the names in the folder of `path` durable, where the system can."""
    if os.name == "posix":
        descriptor = os.open(path.parent, os.O_RDONLY | os.O_CLOEXEC)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _put(part: Path, target: Path, replace: bool) -> None:
    """Gives a finished file its name, durably."""
    descriptor = os.open(part, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        with contextlib.suppress(FileNotFoundError):
            os.fchmod(descriptor, stat.S_IMODE(os.stat(target).st_mode))
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
    if replace or not _linked(part, target):
        os.replace(part, target)
    sync_folder(target)


def _linked(part: Path, target: Path) -> bool:
    """Whether the file could be given a second name, which, unlike renaming, replaces nothing."""
    try:
        os.link(part, target)
    except FileExistsError:
        raise TargetExistsError(f"{printable(str(target))} exists since a moment ago") from None
    except OSError as error:
        if error.errno in _NO_LINKS:
            return False
        raise
    return True


@contextlib.contextmanager
def _one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise WriteError(f"{printable(str(path))}: cannot be written: {error.strerror or error}") from None
