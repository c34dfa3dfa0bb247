"""Micromouse mazes drawn with characters: posts `+` or `o`, walls `---` and `|`, `S` and `G` in cells."""

from __future__ import annotations

from pathlib import Path

from ..errors import WorldFileError
from ..geometry import Point
from ..spec import Box, Shape, Wall, WorldSpec
from ..starts import require_start, with_starts
from ..transforms import scaled

CELL = 0.18
"""Side (m) of a cell of the classic contest."""
THICKNESS = 0.012
HEIGHT = 0.05
POSTS = "+o."
MAX_CELLS = 64


def parse_maze(text: str, source: str, name: str, scale: float = 1.0) -> WorldSpec:
    """The world drawn in a text, starting beside a wall near its `S` (else the lower left cell).

    Raises: WorldFileError naming `source` and line.
    """
    lines = [line.rstrip() for line in text.splitlines()]
    while lines and not lines[-1]:
        lines.pop()
    while lines and not lines[0]:
        lines.pop(0)
    columns, rows = _size(lines, source)
    across, down = _walls(lines, columns, rows, source)
    shapes: list[Shape] = [*_merged(across, rows, flat=True), *_merged(down, rows, flat=False)]
    shapes += _lone_posts(across, down, columns, rows)
    if not shapes:
        raise WorldFileError(f"{source}: a maze without a wall")
    spec = WorldSpec(name, tuple(shapes), description=f"imported from the maze {Path(source).name}")
    x, y = _start_cell(lines, columns, rows)
    return require_start(with_starts(scaled(spec, scale), near=(x * scale, y * scale)), source)


def _size(lines: list[str], source: str) -> tuple[int, int]:
    if len(lines) < 3 or len(lines) % 2 == 0:
        raise WorldFileError(f"{source}: {len(lines)} lines; a maze has 2 n + 1, at least 3")
    columns, rows = (len(lines[0]) - 1) // 4, len(lines) // 2
    if len(lines[0]) != 4 * columns + 1 or columns < 1:
        raise WorldFileError(f"{source}:1: {len(lines[0])} characters; a line of posts has 4 n + 1")
    if max(columns, rows) > MAX_CELLS:
        raise WorldFileError(f"{source}: {columns}x{rows} cells, more than {MAX_CELLS}x{MAX_CELLS}")
    return columns, rows


def _walls(
    lines: list[str], columns: int, rows: int, source: str
) -> tuple[set[tuple[int, int]], set[tuple[int, int]]]:
    """Walls by (line or column of posts from the top or left, cell): lying ones and standing ones."""
    across, down = set(), set()
    for number, line in enumerate(lines):
        if len(line) > 4 * columns + 1:
            raise WorldFileError(f"{source}:{number + 1}: {len(line)} characters, longer than the first line")
        padded = line.ljust(4 * columns + 1)
        if number % 2 == 0:
            for column in range(columns + 1):
                if padded[4 * column] not in POSTS:
                    raise WorldFileError(f"{source}:{number + 1}: no post at character {4 * column + 1}")
            for column in range(columns):
                part = padded[4 * column + 1 : 4 * column + 4]
                if part not in ("---", "   "):
                    raise WorldFileError(f"{source}:{number + 1}: {part!r} is neither a wall '---' nor a gap")
                if part == "---":
                    across.add((number // 2, column))
        else:
            for column in range(columns + 1):
                mark = padded[4 * column]
                if mark not in "| ":
                    raise WorldFileError(f"{source}:{number + 1}: {mark!r} is neither a wall '|' nor a gap")
                if mark == "|":
                    down.add((column, number // 2))
    return across, down


def _merged(walls: set[tuple[int, int]], rows: int, flat: bool) -> list[Shape]:
    """Walls in one line joined; each reaches over the posts at its ends."""
    shapes: list[Shape] = []
    for line, cell in sorted(walls):
        if (line, cell - 1) in walls:
            continue
        end = cell
        while (line, end) in walls:
            end += 1
        low, high = cell * CELL - THICKNESS / 2, end * CELL + THICKNESS / 2
        if flat:
            y = (rows - line) * CELL
            shapes.append(Wall((low, y), (high, y), THICKNESS, HEIGHT))
        else:
            x, top = line * CELL, rows * CELL
            shapes.append(Wall((x, top - high), (x, top - low), THICKNESS, HEIGHT))
    return shapes


def _lone_posts(
    across: set[tuple[int, int]], down: set[tuple[int, int]], columns: int, rows: int
) -> list[Shape]:
    posts: list[Shape] = []
    for row in range(rows + 1):
        for column in range(columns + 1):
            beside = {(row, column), (row, column - 1)} & across or {(column, row), (column, row - 1)} & down
            if not beside:
                posts.append(Box(column * CELL, (rows - row) * CELL, THICKNESS, THICKNESS, 0.0, HEIGHT))
    return posts


def _start_cell(lines: list[str], columns: int, rows: int) -> Point:
    for number in range(1, len(lines), 2):
        found = lines[number].find("S")
        if found >= 0:
            return (min(found // 4, columns - 1) + 0.5) * CELL, (rows - number // 2 - 0.5) * CELL
    return CELL / 2, CELL / 2
