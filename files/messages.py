"""What every message about a file, a name or a value is made of: errors, escapes, suggestions."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable

LONGEST = 60
"""Characters of a foreign name or value that a message quotes; more are cut off."""


class FileError(ValueError):
    """A file that cannot be read or written as asked; one line that names it.

    Whoever reads a file may name another kind of error to be raised (`fault=`), such as `WorldFileError`.
    """


def printable(text: str, keep: str = "") -> str:
    r"""The text with everything escaped that is no visible character, as a terminal may obey it.

    Control characters, line breaks, marks of direction and lone surrogates become `\x1b`, `\n`, `\u202e`.
    keep: characters that stay as they are, such as a line break.
    """
    if text.isprintable() or text.translate(dict.fromkeys(map(ord, keep))).isprintable():
        return text
    return "".join(each if _is_shown(each) or each in keep else _escaped(each) for each in text)


def _is_shown(character: str) -> bool:
    return character.isprintable() or unicodedata.category(character) == "Zs"


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


def quoted(value: object) -> str:
    """A foreign value as messages show it: as Python writes it, with escapes, and cut where it is long."""
    shown = repr(value[: LONGEST + 1]) if isinstance(value, str) else printable(repr(value))
    return shown if len(shown) <= LONGEST + 2 else f"{shown[:LONGEST]}..."


def nearest(name: object, known: Iterable[str]) -> str | None:
    """The known name that was probably meant, if there is one."""
    near = difflib.get_close_matches(str(name)[:LONGEST], list(known), n=1, cutoff=0.5)
    return near[0] if near else None


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """`; did you mean 'X'?` for the nearest known name, or nothing when none is near."""
    near = nearest(name, known)
    return "" if near is None else f"; did you mean {near!r}?"


def unknown(kind: str, name: object, known: Iterable[str]) -> str:
    """A whole message: `unknown KIND 'NAME'; did you mean 'X'? known: ...`."""
    names = list(known)
    near = nearest(name, names)
    hint = "" if near is None else f"did you mean {near!r}? "
    return f"unknown {kind} {quoted(name)}; {hint}known: {', '.join(map(printable, names)) or 'none'}"
