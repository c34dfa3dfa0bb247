"""The gate for all files that are read: regular ones alone, within a limit that the caller names.

Devices, pipes and folders are refused before anything is read, and a pipe never blocks. No more than the
limit is read, whatever size a file says it has, or grows to meanwhile.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from .messages import FileError, printable

PART = 1 << 20
"""Bytes read at a time."""
KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)
AnyPath = str | os.PathLike[str]


def kind_of(mode: int) -> str:
    """What a file is, from its mode, in words."""
    return next((name for is_kind, name in KINDS if is_kind(mode)), "no regular file")


def open_regular(path: AnyPath, fault: type[Exception] = FileError) -> BinaryIO:
    """Opens a regular file for reading bytes; links are followed. The caller closes it.

    Raises: `fault`, one line, when there is none, it is something else, or may not be read.
    """
    shown = printable(os.fspath(path))
    with _one_line(shown, fault):
        mode = os.stat(path).st_mode
    _require_regular(mode, shown, fault)  # before it is opened, as that alone can make a device act
    with _one_line(shown, fault):
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    try:
        _require_regular(os.fstat(descriptor).st_mode, shown, fault)  # it may be another one by now
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


@contextmanager
def _one_line(shown: str, fault: type[Exception]) -> Iterator[None]:
    try:
        yield
    except FileNotFoundError:
        raise fault(f"{shown}: there is no such file") from None
    except OSError as error:
        raise fault(f"{shown}: cannot be read: {error.strerror}") from None
    except ValueError:  # NUL, or a character that no name of a file can hold
        raise fault(f"{shown}: no file can have this name") from None


def _require_regular(mode: int, shown: str, fault: type[Exception]) -> None:
    if not stat.S_ISREG(mode):
        raise fault(f"{shown}: {kind_of(mode)}, not a file; name a regular file")


def read_bytes(path: AnyPath, limit: int, fault: type[Exception] = FileError) -> bytes:
    """What is in a regular file of at most `limit` bytes.

    Raises: `fault`, one line that names the file, when it cannot be read or is larger.
    """
    shown = printable(os.fspath(path))
    data = bytearray()
    with open_regular(path, fault) as file:
        size = os.fstat(file.fileno()).st_size
        with _one_line(shown, fault):
            while size <= limit and (part := file.read(min(PART, limit + 1 - len(data)))):
                data += part
    if max(size, len(data)) > limit:
        raise fault(f"{shown}: larger than the limit of {limit} bytes")
    return bytes(data)


def read_text(path: AnyPath, limit: int, fault: type[Exception] = FileError) -> str:
    r"""The UTF-8 text in a regular file of at most `limit` bytes, lines ended by `\n`.

    Raises: `fault`, one line that names the file, when it cannot be read, is larger or is no such text.
    """
    data = read_bytes(path, limit, fault)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        shown = printable(os.fspath(path))
        raise fault(f"{shown}: not a text file (byte {error.start} is not UTF-8)") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")
