"""YAML read with line numbers, so that an error can say where: file, line and key."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import yaml

from ..errors import WorldFileError

MAX_BYTES = 2_000_000
"""Largest YAML file (bytes) that is read: a hand-written world of thousands of boxes is far smaller."""
MAX_DEPTH = 12
MAX_NUMBER = 1e6
"""Largest number (of meters, degrees, ...) that makes sense anywhere in a world file."""

T = TypeVar("T")


class Entry:
    """One YAML value with its place: file, line and the key path that leads to it."""

    def __init__(self, node: yaml.Node, source: str, key: str = "") -> None:
        """Wraps a composed node."""
        self._node = node
        self._source = source
        self.key = key

    def error(self, problem: str) -> WorldFileError:
        """The error to raise for this value: one line naming file, line and key."""
        where = f"{self._source}:{self._node.start_mark.line + 1}"
        return WorldFileError(f"{where}: {self.key}: {problem}" if self.key else f"{where}: {problem}")

    def _child(self, node: yaml.Node, name: str) -> Entry:
        return Entry(
            node, self._source, f"{self.key}.{name}" if self.key and name[0] != "[" else f"{self.key}{name}"
        )

    def mapping(self, known: Iterable[str] | None = None, required: Iterable[str] = ()) -> dict[str, Entry]:
        """The entries of a mapping by key; keys outside `known` are refused, the nearest one suggested."""
        if not isinstance(self._node, yaml.MappingNode):
            raise self.error(f"expected a mapping of keys, found {self._found()}")
        names = None if known is None else list(known)
        entries: dict[str, Entry] = {}
        for key_node, value_node in self._node.value:
            name = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if not isinstance(name, str) or not name:
                raise self.error("a key must be plain text")
            child = self._child(value_node, name)
            if names is not None and name not in names:
                near = difflib.get_close_matches(name, names, 1, 0.5)
                hint = f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(names)}"
                raise Entry(key_node, self._source, child.key).error(f"unknown key; {hint}")
            if name in entries:
                raise Entry(key_node, self._source, child.key).error("this key appears twice")
            entries[name] = child
        for name in required:
            if name not in entries:
                raise self.error(f"the key {name!r} is missing")
        return entries

    @property
    def is_list(self) -> bool:
        """Whether this is a list."""
        return isinstance(self._node, yaml.SequenceNode)

    def items(self, length: int | None = None) -> list[Entry]:
        """The entries of a list, of exactly `length` if given."""
        if not isinstance(self._node, yaml.SequenceNode):
            raise self.error(f"expected a list, found {self._found()}")
        if length is not None and len(self._node.value) != length:
            raise self.error(f"expected {length} values, found {len(self._node.value)}")
        return [self._child(node, f"[{index}]") for index, node in enumerate(self._node.value)]

    def each(self, read: Callable[[Entry], T]) -> list[T]:
        """What `read` makes of every entry of a list."""
        return [read(entry) for entry in self.items()]

    def text(self) -> str:
        """A plain text value."""
        if not isinstance(self._node, yaml.ScalarNode):
            raise self.error(f"expected text, found {self._found()}")
        return str(self._node.value)

    def one_of(self, choices: Iterable[str]) -> str:
        """One of the given words."""
        value, known = self.text(), list(choices)
        if value not in known:
            near = difflib.get_close_matches(value, known, 1, 0.5)
            raise self.error(
                f"{value!r} is none of {', '.join(known)}" + (f"; did you mean {near[0]!r}?" if near else "")
            )
        return value

    def flag(self) -> bool:
        """`true` or `false`."""
        return self.one_of(("true", "false")) == "true"

    def number(self, low: float = -MAX_NUMBER, high: float = MAX_NUMBER) -> float:
        """A finite number in [low, high]."""
        try:
            value = float(self.text())
        except ValueError:
            raise self.error(f"expected a number, found {self.text()[:40]!r}") from None
        if not (math.isfinite(value) and low <= value <= high):
            raise self.error(f"{value:g} is outside {low:g} to {high:g}")
        return value

    def integer(self, low: int, high: int) -> int:
        """A whole number in [low, high]."""
        value = self.number(low, high)
        if value != int(value):
            raise self.error(f"{value:g} is not a whole number")
        return int(value)

    def numbers(self, length: int, low: float = -MAX_NUMBER, high: float = MAX_NUMBER) -> tuple[float, ...]:
        """A list of `length` finite numbers in [low, high]."""
        return tuple(entry.number(low, high) for entry in self.items(length))

    def _found(self) -> str:
        if isinstance(self._node, yaml.MappingNode):
            return "a mapping"
        if isinstance(self._node, yaml.SequenceNode):
            return "a list"
        return repr(self._node.value[:40]) if self._node.value else "nothing"


def read_yaml(text: str, source: str) -> Entry:
    """The one document in `text`; `source` is the file name for messages.

    Aliases are refused (they can make a small file huge), and so is nesting deeper than MAX_DEPTH.

    Raises: WorldFileError for anything that is not one readable YAML document.
    """
    if len(text) > MAX_BYTES:
        raise WorldFileError(f"{source}: {len(text)} characters of YAML, more than the limit of {MAX_BYTES}")
    try:
        _check_events(text, source)
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        raise WorldFileError(f"{source}{line}: not valid YAML: {error.problem or error.context}") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        raise WorldFileError(f"{source}: not valid YAML: {str(error).splitlines()[0]}") from None
    if node is None:
        raise WorldFileError(f"{source}: the file is empty")
    return Entry(node, source)


def read_text(path: Path, limit: int = MAX_BYTES) -> str:
    """The text of a file.

    Raises: WorldFileError when it cannot be read, is not UTF-8 or is larger than `limit` bytes.
    """
    try:
        if path.stat().st_size > limit:
            raise WorldFileError(f"{path}: {path.stat().st_size} bytes, more than the limit of {limit}")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise WorldFileError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise WorldFileError(f"{path}: not a text file (byte {error.start} is not UTF-8)") from None


def _check_events(text: str, source: str) -> None:
    depth = 0
    events: Any = yaml.parse(text, Loader=yaml.SafeLoader)
    for event in events:
        if isinstance(event, yaml.AliasEvent):
            raise WorldFileError(
                f"{source}:{event.start_mark.line + 1}: aliases (*{event.anchor}) are not allowed"
            )
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            line = event.start_mark.line + 1
            raise WorldFileError(f"{source}:{line}: nested deeper than {MAX_DEPTH} levels")
