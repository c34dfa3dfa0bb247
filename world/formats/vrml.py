"""The text of Webots worlds (VRML97 as Webots writes it) as nodes with fields."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TypeAlias

from ..errors import WorldFileError

MAX_TOKENS = 400_000
MAX_DEPTH = 40
_TOKEN = re.compile(
    r"""(?P<skip>[\s,]+|\#[^\n]*)|(?P<string>"(?:[^"\\]|\\.)*")|(?P<mark>[{}\[\]])"""
    r"""|(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]))|(?P<word>[A-Za-z_][\w.+-]*)""",
    re.VERBOSE | re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Node:
    """One node: its type, the line it begins at, and its fields, each a list of values."""

    kind: str
    line: int
    fields: dict[str, list[Value]] = field(default_factory=dict)

    def numbers(self, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """The numbers of a field, as many as in `default`; the default when the field is not there.

        Raises: ValueError when they are other or of another count.
        """
        values = self.fields.get(name)
        if values is None:
            return default
        found = tuple(value for value in values if isinstance(value, float))
        if len(found) != len(values) or len(found) != len(default):
            raise ValueError(f"line {self.line}: {self.kind}.{name}: expected {len(default)} numbers")
        return found

    def nodes(self, name: str) -> list[Node]:
        """The nodes of a field."""
        return [value for value in self.fields.get(name, ()) if isinstance(value, Node)]


Value: TypeAlias = "float | str | Node"


class _Reader:
    def __init__(self, text: str, source: str) -> None:
        self.source = source
        self.tokens: list[tuple[str, str, int]] = []
        self.place = 0
        self._defined: dict[str, Node] = {}
        self._scan(text)

    def _scan(self, text: str) -> None:
        place, line = 0, 1
        while place < len(text):
            match = _TOKEN.match(text, place)
            if match is None:
                raise self.error(line, f"unexpected {text[place : place + 10]!r}")
            kind, content = str(match.lastgroup), match.group()
            if kind != "skip":
                self.tokens.append((kind, content, line))
                if len(self.tokens) > MAX_TOKENS:
                    raise self.error(line, f"more than {MAX_TOKENS} words")
            line += content.count("\n")
            place = match.end()

    def error(self, line: int, problem: str) -> WorldFileError:
        return WorldFileError(f"{self.source}:{line}: {problem}")

    def peek(self, ahead: int = 0) -> tuple[str, str, int]:
        place = self.place + ahead
        if place < len(self.tokens):
            return self.tokens[place]
        return "end", "the end of the file", self.tokens[-1][2] if self.tokens else 1

    def take(self) -> tuple[str, str, int]:
        token = self.peek()
        self.place += 1
        return token

    def expect(self, mark: str) -> None:
        _, content, line = self.take()
        if content != mark:
            raise self.error(line, f"expected {mark!r}, found {content[:40]!r}")

    def is_node(self) -> bool:
        kind, content, _ = self.peek()
        if kind != "word":
            return False
        return content in ("DEF", "USE") or self.peek(1)[1] == "{"

    def node(self, depth: int) -> Node:
        _, kind, line = self.take()
        if depth > MAX_DEPTH:
            raise self.error(line, f"nested deeper than {MAX_DEPTH} levels")
        if kind == "USE":
            name = self.take()[1]
            if name not in self._defined:
                raise self.error(line, f"USE of {name[:40]!r}, which no DEF names")
            return self._defined[name]
        if kind == "DEF":
            name = self.take()[1]
            node = self._defined[name] = self.node(depth + 1)
            return node
        self.expect("{")
        node = Node(kind, line)
        while self.peek()[1] != "}":
            word, content, place = self.take()
            if word != "word":
                raise self.error(place, f"expected a field of {kind}, found {content[:40]!r}")
            hidden = content == "hidden"  # what Webots notes down for itself, such as a wheel's angle
            field_name = self.take()[1] if hidden else content
            values = self.values(depth)
            if not hidden:
                node.fields[field_name] = values
        self.expect("}")
        return node

    def values(self, depth: int) -> list[Value]:
        if self.peek()[1] == "[":
            self.take()
            found: list[Value] = []
            while self.peek()[1] != "]":
                found += self.some(depth)
            self.take()
            return found
        return self.some(depth)

    def some(self, depth: int) -> list[Value]:
        kind, content, line = self.peek()
        if self.is_node():
            return [self.node(depth + 1)]
        if kind == "number":
            found: list[Value] = []
            while self.peek()[0] == "number":
                found.append(_number(self.take()[1], self, line))
            return found
        self.take()
        if kind == "string":
            return [content[1:-1]]
        if content in ("TRUE", "FALSE", "NULL"):
            return [] if content == "NULL" else [content]
        raise self.error(line, f"expected a value, found {content[:40]!r}")


def _number(text: str, reader: _Reader, line: int) -> float:
    value = float(text)
    if abs(value) > 1e6:
        raise reader.error(line, f"{value:g} is beyond 1e6")
    return value


def version_of(text: str, source: str) -> tuple[int, str]:
    """Year and letter of the Webots that wrote a .wbt file, as in R2023b; (0, "") for older ones, as V8.5.

    Raises: WorldFileError when the text is none.
    """
    begin = re.match(r"#VRML_SIM (?:R(\d{4})([a-z]?)|V\d)", text)
    if begin is None:
        raise WorldFileError(
            f"{source}:1: not a Webots world: it does not begin with '#VRML_SIM' and a version, as R2023b"
        )
    return int(begin[1] or 0), begin[2] or ""


def parse_nodes(text: str, source: str) -> list[Node]:
    """The top-level nodes of a .wbt file.

    Raises: WorldFileError naming `source` and line.
    """
    reader = _Reader(text, source)
    nodes = []
    while reader.peek()[0] != "end":
        _, content, line = reader.peek()
        if content in ("EXTERNPROTO", "IMPORTABLE"):
            reader.take()
            if reader.peek()[0] == "string":
                reader.take()
        elif reader.is_node():
            nodes.append(reader.node(0))
        else:
            raise reader.error(line, f"expected a node, found {content[:40]!r}")
    return nodes
