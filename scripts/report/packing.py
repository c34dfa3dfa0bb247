"""Puts JSON values with arrays in them into few bytes, for assets/unpack.js to read back.

The bytes are: the length of the JSON text (4 bytes, little-endian), the text, spaces up to a multiple of 8,
then the arrays one behind the other, each at a multiple of 8. In the text an array is
`{"$": [offset, type, count], ...}`; `step` says that the numbers are multiples of it, `delta` that each is
the difference to the one before.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_TYPES = "bhiBHf"
"""Characters of the types (as numpy and assets/unpack.js name them) that are packed."""
_SIGNED = (np.int8, np.int16, np.int32)


@dataclass(frozen=True, slots=True)
class Series:
    """Numbers in order, kept as whole multiples of `step`, each as the difference to the one before.

    values: (n,), any unit. What is not finite counts as 0.
    """

    values: ArrayLike
    step: float = 1.0

    def differences(self) -> NDArray[Any]:
        """(n,) the differences, of the smallest type of integers that holds them all."""
        values = np.nan_to_num(np.asarray(self.values, dtype=np.float64), posinf=0.0, neginf=0.0)
        whole = np.clip(np.rint(values / self.step), -(2**29), 2**29).astype(np.int64)
        return smallest(np.diff(whole, prepend=0))


def smallest(values: NDArray[np.int64]) -> NDArray[Any]:
    """Whole numbers in the smallest signed type that holds them."""
    low, high = (int(values.min()), int(values.max())) if values.size else (0, 0)
    for kind in _SIGNED:
        if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max:
            return values.astype(kind)
    raise ValueError(f"numbers from {low} to {high} need more than 32 bits")


def pack(value: Any) -> bytes:
    """The value, with the arrays and series in it, as bytes. Same value, same bytes.

    A float that is not finite becomes null.
    """
    arrays: list[bytes] = []
    size = 0

    def plain(item: Any) -> Any:
        nonlocal size
        if isinstance(item, Mapping):
            return {str(key): plain(each) for key, each in item.items()}
        if isinstance(item, list | tuple):
            return [plain(each) for each in item]
        further: dict[str, Any] = {}
        if isinstance(item, Series):
            item, further = item.differences(), {"delta": 1, "step": item.step}
        if not isinstance(item, np.ndarray):
            item = item.item() if isinstance(item, np.generic) else item
            return None if isinstance(item, float) and not math.isfinite(item) else item
        data = np.ascontiguousarray(item).astype(item.dtype.newbyteorder("<")).tobytes()
        if item.dtype.char not in _TYPES:
            raise ValueError(f"arrays of {item.dtype} are not packed")
        place = [size, item.dtype.char, item.size]
        arrays.append(data + b"\0" * (-len(data) % 8))
        size += len(arrays[-1])
        return {"$": place, **further}

    text = json.dumps(plain(value), separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(len(text) + 4) % 8)
    return len(text).to_bytes(4, "little") + text + b"".join(arrays)
