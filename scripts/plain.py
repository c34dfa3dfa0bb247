"""Values as JSON has them: plain types, floats without false precision, and reports that turn into them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def plain(value: Any) -> Any:
    """The same value in JSON's own types: numpy turned to Python, numbers that are not finite to None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)


def rounded(value: Any) -> Any:
    """The same value with floats to 1e-6: what is beyond is noise to a reader."""
    if isinstance(value, float):
        return round(value, 6)
    if isinstance(value, Mapping):
        return {name: rounded(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return value


def report_values(report: DataclassInstance) -> dict[str, Any]:
    """The fields of a report as JSON values, but for those that take no part in comparing two."""
    names = [entry.name for entry in fields(report) if entry.compare]
    return {name: rounded(getattr(report, name)) for name in names}
