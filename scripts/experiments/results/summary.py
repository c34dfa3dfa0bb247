"""Numbers of many runs put together: mean, worst, and how sure one can be of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

RESAMPLES = 4000
"""Bootstrap samples of an interval: its ends then repeat to a few percent of its width."""


@dataclass(frozen=True, slots=True)
class Summary:
    """Of `count` runs: least, mean and greatest, and a 95 % interval (low, high) of the mean."""

    count: int
    least: float
    mean: float
    greatest: float
    low: float
    high: float


def summarize(values: Sequence[float]) -> Summary | None:
    """The summary of finite values, None of none.

    The interval is the bootstrap's percentiles, with draws that depend on the number of values alone: errors
    are skewed, and a normal interval would reach below zero.

    Raises: ValueError for a value that is not finite.
    """
    if not values:
        return None
    data = np.asarray(values, dtype=float)
    if not np.isfinite(data).all():
        raise ValueError("a run without a finite value must be counted as lost, not averaged")
    draws = np.random.default_rng(len(data)).integers(len(data), size=(RESAMPLES, len(data)))
    low, high = np.percentile(data[draws].mean(axis=1), [2.5, 97.5])
    return Summary(
        len(data), float(data.min()), float(data.mean()), float(data.max()), float(low), float(high)
    )


def share(successes: int, runs: int) -> tuple[float, float, float]:
    """A share of successes and its 95 % interval (Wilson's score), each in [0, 1].

    Raises: ValueError unless 0 <= successes <= runs and there are runs.
    """
    if not 0 <= successes <= runs or runs == 0:
        raise ValueError(f"{successes} of {runs} is no share")
    z = 1.959964
    p = successes / runs
    center = (p + z * z / (2 * runs)) / (1 + z * z / runs)
    half = z / (1 + z * z / runs) * math.sqrt(p * (1 - p) / runs + z * z / (4 * runs * runs))
    return p, max(0.0, center - half), min(1.0, center + half)


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; the first column is text, the others are aligned to the right."""
    widths = [max(len(row[column]) for row in [header, *rows]) for column in range(len(header))]

    def line(cells: Sequence[str]) -> str:
        first = cells[0].ljust(widths[0])
        rest = [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        return "| " + " | ".join([first, *rest]) + " |"

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join([line(header), "| " + " | ".join(rule) + " |", *(line(row) for row in rows)])
