"""Gray images from PGM and PNG files, within bounds of size."""

from __future__ import annotations

import importlib
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import WorldFileError

MAX_PIXELS = 4096 * 4096
MAX_BYTES = 64_000_000
Gray = NDArray[np.float64]
"""(height, width), 0..1, row 0 on top."""


def read_bitmap(path: Path) -> Gray:
    """The image in a PGM or PNG file, told apart by its first bytes.

    Raises: WorldFileError when it cannot be read, is damaged or too large.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise WorldFileError(f"{path}: {path.stat().st_size} bytes, more than the limit of {MAX_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise WorldFileError(f"{path}: cannot be read: {error.strerror}") from None
    return parse_bitmap(data, str(path))


def parse_bitmap(data: bytes, source: str) -> Gray:
    """The image in the bytes of a PGM or PNG file; `source` is the name for messages.

    Raises: WorldFileError when it is neither, damaged or too large.
    """
    if data[:2] in (b"P2", b"P5"):
        return _parse_pgm(data, source)
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return _parse_png(data, source)
    raise WorldFileError(f"{source}: neither a PGM (P2, P5) nor a PNG image")


def _parse_pgm(data: bytes, source: str) -> Gray:
    (width, height, top), begin = _pgm_header(data, source)
    if not (0 < top <= 65535 and width > 0 and height > 0):
        raise WorldFileError(f"{source}: PGM of {width}x{height} with maximum {top} makes no sense")
    _check_pixels(width, height, source)
    count = width * height
    if data[:2] == b"P2":
        words = data[begin:].split(None, count)[:count]
        if not all(word.isdigit() and len(word) < 6 for word in words):
            raise WorldFileError(f"{source}: a PGM value is not a number of 0..65535")
        values = np.array([int(word) for word in words], dtype=np.float64)
    else:
        kind = np.dtype(np.uint8) if top < 256 else np.dtype(">u2")
        body = data[begin : begin + count * kind.itemsize]
        values = np.frombuffer(body[: len(body) // kind.itemsize * kind.itemsize], kind).astype(np.float64)
    if len(values) != count:
        raise WorldFileError(f"{source}: {len(values)} pixels, {count} expected for {width}x{height}")
    image: Gray = np.minimum(values / top, 1.0).reshape(height, width)
    return image


def _pgm_header(data: bytes, source: str) -> tuple[list[int], int]:
    """Width, height and maximum, and where the pixels begin."""
    numbers: list[int] = []
    place = 2
    while len(numbers) < 3:
        while place < len(data) and (data[place : place + 1].isspace() or data[place] == ord("#")):
            if data[place] == ord("#"):
                end = data.find(b"\n", place)
                place = len(data) if end < 0 else end
            else:
                place += 1
        end = place
        while end < len(data) and data[end : end + 1].isdigit() and end - place < 9:
            end += 1
        if end == place:
            raise WorldFileError(f"{source}: the PGM header is damaged at byte {place}")
        numbers.append(int(data[place:end]))
        place = end
    return numbers, place + 1


def _parse_png(data: bytes, source: str) -> Gray:
    pillow: Any = importlib.import_module("PIL.Image")
    try:
        with pillow.open(io.BytesIO(data), formats=["PNG"]) as image:
            width, height = image.size
            _check_pixels(width, height, source)
            gray = image if image.mode in ("I;16", "I") else image.convert("L")
            top = 65535.0 if gray.mode in ("I;16", "I") else 255.0
            values: Gray = np.asarray(gray, dtype=np.float64) / top
    except WorldFileError:
        raise
    except Exception as error:  # Pillow raises many kinds for a damaged file
        raise WorldFileError(f"{source}: a damaged PNG image: {error}") from None
    return values


def _check_pixels(width: int, height: int, source: str) -> None:
    if width * height > MAX_PIXELS:
        raise WorldFileError(f"{source}: {width}x{height} pixels, more than the limit of {MAX_PIXELS}")
