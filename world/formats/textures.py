"""Textures: drawn by a pattern, given row by row, or read from a bitmap."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...files.yaml_nodes import Entry
from ..errors import WorldFileError
from ..spec import Texture
from .bitmaps import read_bitmap

PATTERNS = ("stripes", "bars", "checks", "noise", "gradient")
KEYS = ("pattern", "size", "seed", "low", "high", "rows", "file")
MAX_SIDE = 512
"""Largest width and height (pixels) of a texture."""


def read_textures(entry: Entry, folder: Path | None) -> tuple[Texture, ...]:
    """The textures that a world file describes, by name."""
    return tuple(_texture(name, value, folder) for name, value in entry.mapping().items())


def _texture(name: str, entry: Entry, folder: Path | None) -> Texture:
    keys = entry.mapping(KEYS)
    if sum(key in keys for key in ("pattern", "rows", "file")) != 1:
        raise entry.error("a texture has one of 'pattern', 'rows' and 'file'")
    if "file" in keys:
        return _from_file(name, keys["file"], folder)
    if "rows" in keys:
        rows = [tuple(cell.number(0.0, 1.0) for cell in row.items()) for row in keys["rows"].items()]
        if not rows or not rows[0] or len({len(row) for row in rows}) != 1:
            raise keys["rows"].error("rows must be of one length and not empty")
        return Texture(name, tuple(rows))
    width, height = (
        (side.integer(1, MAX_SIDE) for side in keys["size"].items(2)) if "size" in keys else (8, 4)
    )
    low = keys["low"].number(0.0, 1.0) if "low" in keys else 0.2
    high = keys["high"].number(0.0, 1.0) if "high" in keys else 1.0
    seed = keys["seed"].integer(0, 2**31) if "seed" in keys else 0
    return drawn(name, keys["pattern"].one_of(PATTERNS), width, height, low, high, seed)


def _from_file(name: str, entry: Entry, folder: Path | None) -> Texture:
    if folder is None:
        raise entry.error("bitmaps can only be named in a world file on disk")
    path = folder / entry.text()
    try:
        image = read_bitmap(path, MAX_SIDE**2).gray
    except WorldFileError as error:
        raise entry.error(str(error)) from None
    if max(image.shape) > MAX_SIDE:
        raise entry.error(f"{image.shape[1]}x{image.shape[0]} pixels, more than {MAX_SIDE}x{MAX_SIDE}")
    return Texture(name, tuple(tuple(row) for row in np.round(image, 6).tolist()))


def drawn(
    name: str, pattern: str, width: int, height: int, low: float, high: float, seed: int = 0
) -> Texture:
    """A texture from a pattern: `width` x `height` pixels between luminances `low` and `high`."""
    column, row = np.meshgrid(np.arange(width), np.arange(height))
    shares = {
        "stripes": (column % 2).astype(float),
        "bars": (row % 2).astype(float),
        "checks": ((column + row) % 2).astype(float),
        "noise": np.random.default_rng(seed).random((height, width)),
        "gradient": column / max(width - 1, 1),
    }
    values = np.round(low + (high - low) * shares[pattern], 6)
    return Texture(name, tuple(tuple(float(value) for value in line) for line in values))
