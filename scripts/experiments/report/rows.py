"""Figures and rows of the tables: published, profile `thesis`, profile `default` and target, side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..campaign.plan import Outcome, Plan
from ..campaign.summary import Summary, share, summarize
from .published import PUBLISHED
from .targets import TARGETS, Target

Values = Callable[[Outcome, str, str], list[float]]
Share = Callable[[Outcome, str, str], tuple[int, int]]


@dataclass(frozen=True, slots=True)
class Measured:
    """One figure of one profile: a summary of values, or `count` of `runs` with its share's interval."""

    summary: Summary | None = None
    count: int | None = None
    runs: int = 0

    def to_json(self) -> dict[str, Any]:
        """Plain values, None where nothing was measured."""
        if self.count is not None:
            low, high = share(self.count, self.runs)[1:] if self.runs else (None, None)
            return {"count": self.count, "runs": self.runs, "low": low, "high": high}
        found = self.summary
        if found is None:
            return {"runs": 0}
        return {
            "runs": found.count,
            "mean": found.mean,
            "least": found.least,
            "worst": found.greatest,
            "low": found.low,
            "high": found.high,
        }


@dataclass(frozen=True, slots=True)
class Row:
    """One figure in one environment. published: (mean, least, greatest), None where the thesis has none."""

    figure: str
    unit: str
    environment: str
    published: tuple[float | None, float | None, float | None]
    measured: dict[str, Measured]
    target: str = ""
    reached: bool | None = None
    reproduced: bool | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "figure": self.figure,
            "unit": self.unit,
            "environment": self.environment,
            "published": dict(zip(("mean", "least", "greatest"), self.published, strict=True)),
            "measured": {profile: found.to_json() for profile, found in self.measured.items()},
            "target": self.target,
            "reached": self.reached,
            "reproduced": self.reproduced,
        }


@dataclass(frozen=True, slots=True)
class Figure:
    """How one figure is made: from `values`, or counted by `counted`.

    published: the names in the published table of its mean, least and greatest. wanted: the share of runs
    that is the target of a count. only: the profile that has it, if not both.
    """

    name: str
    unit: str
    values: Values | None = None
    counted: Share | None = None
    published: tuple[str, str, str] = ("", "", "")
    wanted: float | None = None
    only: str = ""


Remark = Callable[[Plan, Outcome], str]


@dataclass(frozen=True, slots=True)
class Table:
    """One table of the report. remarks: sentences about it as a whole, "" where there is nothing to say."""

    number: str
    title: str
    figures: Sequence[Figure]
    notes: Sequence[str] = field(default_factory=tuple)
    remarks: Sequence[Remark] = field(default_factory=tuple)


def rows_of(table: Table, plan: Plan, outcome: Outcome) -> list[Row]:
    """The table's rows, figure by figure, environment by environment."""
    return [
        _row(table, figure, plan, outcome, index, world)
        for figure in table.figures
        for index, world in enumerate(plan.environments)
    ]


def _row(table: Table, figure: Figure, plan: Plan, outcome: Outcome, index: int, world: str) -> Row:
    figures = PUBLISHED[table.number].figures if table.number in PUBLISHED else {}
    mean, least, greatest = (
        figures[name].values[index] if name in figures else None for name in figure.published
    )
    measured: dict[str, Measured] = {}
    for profile in plan.profiles:
        if figure.only in ("", profile):
            measured[profile] = _measure(figure, outcome, world, profile)
    target = TARGETS.get((table.number, figure.name), Target())
    text = target.describe(index)
    if figure.wanted is not None:
        text = f"{100 * figure.wanted:.0f} % of the runs"
    return Row(
        figure.name,
        figure.unit,
        world,
        (mean, least, greatest),
        measured,
        text,
        _reached(measured.get("default"), target, figure.wanted, index) if text else None,
        _reproduced(measured.get("thesis"), least, greatest),
    )


def _measure(figure: Figure, outcome: Outcome, world: str, profile: str) -> Measured:
    if figure.counted is not None:
        count, runs = figure.counted(outcome, world, profile)
        return Measured(count=count, runs=runs)
    assert figure.values is not None
    values = figure.values(outcome, world, profile)
    return Measured(summarize([value for value in values if math.isfinite(value)]))


def _reached(found: Measured | None, target: Target, wanted: float | None, index: int) -> bool | None:
    if found is None:
        return None
    if wanted is not None:
        return found.count == round(wanted * found.runs) if found.runs else None
    if found.summary is None:
        return None
    return target.reached(index, found.summary.mean, found.summary.greatest)


def _reproduced(found: Measured | None, least: float | None, greatest: float | None) -> bool | None:
    """Whether the mean lies within the published least and greatest value."""
    if found is None or found.summary is None or least is None or greatest is None:
        return None
    return least <= found.summary.mean <= greatest
