"""Figures that benchmarks measure, printed beside their targets."""

from __future__ import annotations

import statistics
import time
import timeit
from collections.abc import Callable, Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """One measured value. target: None for what is only reported. at_least: whether more is better."""

    name: str
    value: float
    unit: str
    target: float | None = None
    at_least: bool = False

    @property
    def reached(self) -> bool:
        """Whether the target holds; true where there is none."""
        if self.target is None:
            return True
        return self.value >= self.target if self.at_least else self.value <= self.target

    def line(self) -> str:
        """The figure for people."""
        text = f"{self.name:<58} {self.value:>10.4g} {self.unit:<3}"
        if self.target is None:
            return text.rstrip()
        sign = ">=" if self.at_least else "<="
        return f"{text} {sign} {self.target:g}{'' if self.reached else '   MISSED'}"


def report(figures: Iterable[Figure]) -> int:
    """Prints figures as they come; how many of them miss their target."""
    missed = 0
    for figure in figures:
        print(figure.line(), flush=True)
        missed += not figure.reached
    return missed


def median_seconds(work: Callable[[], object], times: int) -> float:
    """The median of the processor's seconds of some calls, after one that is not counted."""
    work()
    return statistics.median(timeit.repeat(work, number=1, repeat=times, timer=time.process_time))
