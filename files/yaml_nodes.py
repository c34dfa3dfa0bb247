"""YAML read with line numbers, so that an error can say where: file, line and key.

A cautious part of YAML: no aliases, tags, directives or keys that appear twice, and a plain scalar is what
YAML 1.2's core schema makes of it: a date is text, and so are `yes` and `1:30`. Read in one pass over the
events of PyYAML's C parser, or of its Python one where that is missing.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from .messages import FileError, did_you_mean, nearest, printable, quoted

MAX_BYTES = 2_000_000
"""Largest YAML file (bytes) that is read: a hand-written world of thousands of boxes is far smaller."""
MAX_DEPTH = 64
"""Lists and mappings within one another."""
MAX_VALUES = 400_000
MAX_NUMBER = 1e6
"""Largest number (of meters, degrees, seconds, ...) that makes sense where no other limit is named."""

Scalar = str | int | float | bool | None
T = TypeVar("T")

_INTEGER = re.compile(r"[-+]?[0-9]+", re.ASCII)
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", re.ASCII)
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_WORDS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


@dataclass(frozen=True, slots=True)
class Document:
    """What all values of a file share: its name for messages, and the kind of error to raise."""

    source: str
    fault: type[Exception]

    def error(self, line: int, problem: str) -> Exception:
        """The error to raise for something on a line, counted from 1."""
        return self.fault(f"{printable(self.source)}:{line}: {problem}")


class Entry:
    """One YAML value with its place: file, line and the keys that lead to it."""

    __slots__ = ("_document", "_key_line", "_parent", "_plain", "_step", "_value", "line")

    def __init__(
        self,
        document: Document,
        parent: Entry | None,
        step: str | int,
        line: int,
        key_line: int,
        value: str | list[Entry] | dict[str, Entry],
        plain: bool = False,
    ) -> None:
        """step: key or index in `parent`. plain: whether a scalar stands without quotes."""
        self._document = document
        self._parent = parent
        self._step = step
        self.line = line
        self._key_line = key_line
        self._value = value
        self._plain = plain

    @property
    def key(self) -> str:
        """The keys and indices that lead here from the top: `boxes[3].size`."""
        steps: list[str] = []
        entry: Entry | None = self
        while entry is not None and entry._parent is not None:
            steps.append(f"[{entry._step}]" if isinstance(entry._step, int) else f".{entry._step[:60]}")
            entry = entry._parent
        return printable("".join(reversed(steps)).removeprefix("."))

    def error(self, problem: str) -> Exception:
        """The error to raise for this value: one line naming file, line and key."""
        return self._error(self.line, problem)

    def key_error(self, problem: str) -> Exception:
        """The error to raise for the key of this value, which may stand on an earlier line."""
        return self._error(self._key_line, problem)

    def _error(self, line: int, problem: str) -> Exception:
        key = self.key
        return self._document.error(line, f"{key}: {problem}" if key else problem)

    def found(self) -> str:
        """What this value is, for messages."""
        if isinstance(self._value, dict):
            return "a mapping"
        if isinstance(self._value, list):
            return "a list"
        if not self.is_nothing:
            return quoted(self._value)
        return "nothing" if self._parent else "nothing: the file is empty"

    @property
    def is_mapping(self) -> bool:
        """Whether this is a mapping of keys."""
        return isinstance(self._value, dict)

    @property
    def is_list(self) -> bool:
        """Whether this is a list."""
        return isinstance(self._value, list)

    @property
    def is_scalar(self) -> bool:
        """Whether this is neither a list nor a mapping."""
        return isinstance(self._value, str)

    @property
    def is_nothing(self) -> bool:
        """Whether there is no value, or `null`."""
        return self._plain and isinstance(self._value, str) and _WORDS.get(self._value, "") is None

    def mapping(self, known: Iterable[str] | None = None, required: Iterable[str] = ()) -> dict[str, Entry]:
        """The entries of a mapping by key; keys outside `known` are refused, the nearest one suggested."""
        if not isinstance(self._value, dict):
            raise self.error(f"expected a mapping of keys, found {self.found()}")
        names = self._value.keys() if known is None else tuple(known)
        for name, entry in self._value.items():
            if name not in names:
                near = nearest(name, names)
                hint = f"did you mean {near!r}?" if near else f"known keys: {', '.join(names)}"
                raise entry.key_error(f"unknown key; {hint}")
        for name in required:
            if name not in self._value:
                raise self.error(f"the key {name!r} is missing")
        return dict(self._value)

    def items(self, length: int | None = None) -> list[Entry]:
        """The entries of a list, of exactly `length` if given."""
        if not isinstance(self._value, list):
            raise self.error(f"expected a list, found {self.found()}")
        if length is not None and len(self._value) != length:
            raise self.error(f"expected {length} values, found {len(self._value)}")
        return self._value

    def each(self, read: Callable[[Entry], T]) -> list[T]:
        """What `read` makes of every entry of a list."""
        return [read(entry) for entry in self.items()]

    def text(self) -> str:
        """A text; numbers, dates and words such as `true` are taken as they are written."""
        if not isinstance(self._value, str) or self.is_nothing:
            raise self.error(f"expected text, found {self.found()}")
        return self._shown(self._value)

    def _shown(self, text: str) -> str:
        """The text, if it holds no control characters but line breaks and tabs."""
        if not text.isprintable() and _CONTROL.search(text):
            raise self.error(f"{quoted(text)} holds control characters; leave them out")
        return text

    def one_of(self, choices: Iterable[str]) -> str:
        """One of the given words."""
        value, known = self.text(), list(choices)
        if value not in known:
            raise self.error(f"{quoted(value)} is none of {', '.join(known)}{did_you_mean(value, known)}")
        return value

    def flag(self) -> bool:
        """`true` or `false`."""
        value = self.scalar()
        if not isinstance(value, bool):
            raise self.error(f"expected true or false, found {self.found()}")
        return value

    def number(self, low: float = -MAX_NUMBER, high: float = MAX_NUMBER) -> float:
        """A finite number in [low, high]."""
        value = self._value
        if not isinstance(value, str) or not self._plain or not _FLOAT.fullmatch(value):
            raise self.error(f"expected a number, found {self.found()}")
        number = float(value)
        if not low <= number <= high:
            raise self.error(f"{number:g} is outside {low:g} to {high:g}")
        return number

    def integer(self, low: int, high: int) -> int:
        """A whole number in [low, high]."""
        value = self.number(low, high)
        if value != int(value):
            raise self.error(f"{value:g} is not a whole number")
        return int(value)

    def numbers(self, length: int, low: float = -MAX_NUMBER, high: float = MAX_NUMBER) -> tuple[float, ...]:
        """A list of `length` finite numbers in [low, high]."""
        return tuple([entry.number(low, high) for entry in self.items(length)])

    def scalar(self) -> Scalar:
        """A text, whole number, finite number, truth value or None, as YAML's core schema reads it."""
        if not isinstance(self._value, str):
            raise self.error(f"expected a single value, found {self.found()}")
        return self._typed(self._value) if self._plain else self._shown(self._value)

    def _typed(self, text: str) -> Scalar:
        if text in _WORDS:
            return _WORDS[text]
        if _INTEGER.fullmatch(text) and len(text) < 20:
            return int(text)
        if _FLOAT.fullmatch(text):
            if not math.isfinite(value := float(text)):
                raise self.error(f"{quoted(text)} is too large")
            return value
        if _NOT_FINITE.fullmatch(text):
            raise self.error(f"expected a finite number, found {text!r}")
        return self._shown(text)

    def data(self) -> Any:
        """The value as plain Python: dicts, lists and scalars (see `scalar`)."""
        if isinstance(self._value, dict):
            return {name: entry.data() for name, entry in self._value.items()}
        if isinstance(self._value, list):
            return [entry.data() for entry in self._value]
        return self.scalar()

    def substituted(self, old: str, new: str) -> Entry:
        """The same with `new` for `old` in all texts; what is plain is then read as it stands: `$n` as 3."""
        return self._copied(self._parent, old, new)

    def _copied(self, parent: Entry | None, old: str, new: str) -> Entry:
        value = self._value.replace(old, new) if isinstance(self._value, str) else self._value
        copy = Entry(self._document, parent, self._step, self.line, self._key_line, value, self._plain)
        if isinstance(value, dict):
            copy._value = {name: entry._copied(copy, old, new) for name, entry in value.items()}
        elif isinstance(value, list):
            copy._value = [entry._copied(copy, old, new) for entry in value]
        return copy


def parse_yaml(text: str, source: str, fault: type[Exception] = FileError, depth: int = MAX_DEPTH) -> Entry:
    """The one document in `text`, or nothing if it is empty.

    source: the file's name for messages. depth: most levels of nesting.

    Raises: `fault`, one line, for anything that is not one document of the YAML that is read here.
    """
    document = Document(source, fault)
    if len(text) > MAX_BYTES:
        raise fault(
            f"{printable(source)}: {len(text)} characters of YAML, more than the limit of {MAX_BYTES}"
        )
    if (place := re.search(r"^%", text, re.MULTILINE)) is not None:
        raise document.error(
            text.count("\n", 0, place.start()) + 1, "directives such as %YAML are not allowed"
        )
    yaml: Any = importlib.import_module("yaml")  # here, so that what may read a file loads no parser
    try:
        return _Builder(document, depth).build(text, yaml)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = " ".join(f"not valid YAML: {error.problem or error.context}".split())
        raise document.error(mark.line + 1 if mark else 1, problem) from None
    except yaml.YAMLError as error:
        problem = " ".join(str(error).split())
        raise fault(f"{printable(source)}: not valid YAML: {printable(problem)}") from None
    except UnicodeEncodeError:
        raise fault(f"{printable(source)}: not valid YAML: characters that UTF-8 cannot hold") from None


def _loader(yaml: Any) -> Any:
    return getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Builder:
    """Makes entries of the parser's events, without recursion."""

    def __init__(self, document: Document, depth: int) -> None:
        self._document = document
        self._depth = depth
        self._open: list[Entry] = []
        self._key: tuple[str, int] | None = None
        self._top: Entry | None = None
        self._count = 0

    def build(self, text: str, yaml: Any) -> Entry:
        events = yaml.parse(text, Loader=_loader(yaml))
        for event in events:
            kind = type(event)
            if kind is yaml.ScalarEvent:
                self._scalar(event)
            elif kind is yaml.SequenceStartEvent:
                self._begin(event, [])
            elif kind is yaml.MappingStartEvent:
                self._begin(event, {})
            elif kind is yaml.SequenceEndEvent or kind is yaml.MappingEndEvent:
                self._open.pop()
            elif kind is yaml.AliasEvent:
                entry = self._entry(event, "")
                raise entry.error(f"aliases (*{event.anchor[:40]}) are not allowed; write the value out")
            elif kind is yaml.DocumentStartEvent and self._top is not None:
                raise self._document.error(event.start_mark.line + 1, "a second document; one is read")
        return self._top or Entry(self._document, None, "", 1, 1, "", True)

    def _scalar(self, event: Any) -> None:
        parent = self._open[-1] if self._open else None
        if parent is None or self._key is not None or not isinstance(parent._value, dict):
            self._entry(event, event.value)
            return
        line = event.start_mark.line + 1
        self._key = event.value, line
        if event.value == "" or _CONTROL.search(event.value):
            raise self._document.error(line, "a key must be plain text")
        if event.value in parent._value:
            raise Entry(self._document, parent, event.value, line, line, "").error("this key appears twice")

    def _begin(self, event: Any, value: list[Entry] | dict[str, Entry]) -> None:
        if self._open and isinstance(self._open[-1]._value, dict) and self._key is None:
            raise self._document.error(event.start_mark.line + 1, "a key must be plain text")
        if len(self._open) == self._depth:
            line = event.start_mark.line + 1
            raise self._document.error(line, f"nested deeper than {self._depth} levels")
        self._open.append(self._entry(event, value))

    def _entry(self, event: Any, value: str | list[Entry] | dict[str, Entry]) -> Entry:
        """A new entry in its place in the innermost list or mapping."""
        line = event.start_mark.line + 1
        parent = self._open[-1] if self._open else None
        step, key_line = self._key or ("", line)
        entry = Entry(self._document, parent, step, line, key_line, value)
        if parent is None:
            self._top = entry
        elif isinstance(parent._value, dict):
            parent._value[step] = entry
            self._key = None
        elif isinstance(parent._value, list):
            entry._step = len(parent._value)
            parent._value.append(entry)
        self._count += 1
        if self._count > MAX_VALUES:
            raise self._document.error(line, f"more than {MAX_VALUES} values")
        if getattr(event, "tag", None) is not None:
            raise entry.error(f"tags ({printable(event.tag[:40])}) are not allowed; leave it out")
        if isinstance(value, str):
            entry._plain = getattr(event, "style", None) in (None, "")
        return entry
