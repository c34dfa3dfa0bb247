"""Gray images from PGM and PNG files, within bounds of size."""

from __future__ import annotations

import importlib
import io
import re
import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...files.messages import printable
from ...files.reading import read_bytes
from ..errors import WorldFileError

MAX_PIXELS = 4096 * 4096
MAX_BYTES = 64_000_000
Gray = NDArray[np.float64]
"""(height, width), 0..1, row 0 on top."""


class Bitmap(NamedTuple):
    """What an image shows. opaque: which pixels are not transparent, not even partly."""

    gray: Gray
    opaque: NDArray[np.bool_] | bool = True


def read_bitmap(path: Path, most: int = MAX_PIXELS) -> Bitmap:
    """The image in a PGM or PNG file of at most `most` pixels, told apart by its first bytes.

    Raises: WorldFileError when it cannot be read, is damaged or too large.
    """
    return parse_bitmap(read_bytes(path, MAX_BYTES, WorldFileError), printable(str(path)), most)


def parse_bitmap(data: bytes, source: str, most: int = MAX_PIXELS) -> Bitmap:
    """The image in the bytes of a PGM or PNG file; `source` is the name for messages.

    Nothing is decoded before the size that the image says it has is known to be within bounds.

    Raises: WorldFileError when it is neither, damaged or has more than `most` pixels.
    """
    if data[:2] in (b"P2", b"P5"):
        return Bitmap(_parse_pgm(data, source, most))
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return _parse_png(data, source, most)
    raise WorldFileError(f"{source}: neither a PGM (P2, P5) nor a PNG image")


def _parse_pgm(data: bytes, source: str, most: int) -> Gray:
    (width, height, top), begin = _pgm_header(data, source)
    if not (0 < top <= 65535 and width > 0 and height > 0):
        raise WorldFileError(f"{source}: PGM of {width}x{height} with maximum {top} makes no sense")
    _check_pixels(width, height, source, most)
    count = width * height
    if data[:2] == b"P2":
        values = _written_out(data[begin:], count, source)
    else:
        kind = np.dtype(np.uint8) if top < 256 else np.dtype(">u2")
        there = min(count, max(0, len(data) - begin) // kind.itemsize)
        values = np.frombuffer(data, kind, there, begin).astype(np.float64) if there else np.empty(0)
    if len(values) != count:
        raise WorldFileError(f"{source}: {len(values)} pixels, {count} expected for {width}x{height}")
    values /= top
    return np.minimum(values, 1.0, out=values).reshape(height, width)


def _written_out(text: bytes, count: int, source: str) -> NDArray[np.float64]:
    """The first `count` numbers of a text."""
    if text.translate(None, b"0123456789 \t\r\n\v\f") or re.search(rb"\d{6}", text):
        raise WorldFileError(f"{source}: a PGM value is not a number of 0..65535")
    return np.fromstring(text.decode("ascii"), np.float64, count if text.strip() else 0, sep=" ")


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


def _parse_png(data: bytes, source: str, most: int) -> Bitmap:
    if len(data) < 24:
        raise WorldFileError(f"{source}: a damaged PNG image: it ends in its header")
    width, height = struct.unpack(">II", data[16:24])
    _check_pixels(width, height, source, most)
    pillow: Any = importlib.import_module("PIL.Image")
    try:
        with pillow.open(io.BytesIO(data), formats=["PNG"]) as image:
            gray = image if image.mode in ("I;16", "I") else image.convert("L")
            top = 65535.0 if gray.mode in ("I;16", "I") else 255.0
            values: Gray = np.asarray(gray, dtype=np.float64) / top
            if "A" not in image.getbands() and "transparency" not in image.info:
                return Bitmap(values)
            return Bitmap(values, np.asarray(image.convert("RGBA").getchannel("A")) == 255)
    except Exception as error:  # Pillow raises many kinds for a damaged file
        raise WorldFileError(f"{source}: a damaged PNG image: {printable(str(error))}") from None


def _check_pixels(width: int, height: int, source: str, most: int) -> None:
    if width * height > most:
        raise WorldFileError(f"{source}: {width}x{height} pixels, more than the limit of {most}")
