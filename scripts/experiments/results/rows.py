"""Figures and rows of the tables: published, profile `thesis`, profile `default` and target, side by side."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from ..campaign.kinds import ENVIRONMENTS
from ..campaign.plan import Outcome, Plan
from .published import PUBLISHED
from .published import Figure as Published
from .summary import Summary, share, summarize
from .tables import SCALES, Figure, Runs, Table
from .targets import TARGETS, Target


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
        if self.summary is None:
            return {"runs": 0}
        values = asdict(self.summary)
        return {"runs": values.pop("count"), "worst": values.pop("greatest"), **values}


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
        return asdict(self) | {
            "published": dict(zip(("mean", "least", "greatest"), self.published, strict=True)),
            "measured": {profile: found.to_json() for profile, found in self.measured.items()},
        }


def rows_of(table: Table, plan: Plan, outcome: Outcome) -> list[Row]:
    """The table's rows, figure by figure, environment by environment."""
    return [
        _row(table, figure, plan, outcome, ENVIRONMENTS.index(world), world)
        for figure in table.figures
        for world in plan.environments
    ]


def _row(table: Table, figure: Figure, plan: Plan, outcome: Outcome, index: int, world: str) -> Row:
    measured = {
        profile: _measure(figure, partial(outcome.runs, environment=world, profile=profile))
        for profile in plan.profiles
        if figure.only in ("", profile)
    }
    there = PUBLISHED[table.number].figures.get(figure.published, Published())
    published = there.mean[index], there.least[index], there.greatest[index]
    target = TARGETS.get((table.number, figure.name), Target())
    text = target.describe(index)
    if figure.wanted is not None:
        text = f"{100 * figure.wanted:.0f} % of the runs"
    return Row(
        figure.name,
        figure.unit,
        world,
        published,
        measured,
        text,
        _reached(measured.get("default"), target, figure.wanted, index) if text else None,
        _reproduced(measured.get("thesis"), *published[1:]),
    )


def _measure(figure: Figure, runs: Runs) -> Measured:
    if figure.counted is not None:
        kind, test = figure.counted
        results = [result for _, result in runs(kind)]
        return Measured(count=sum(map(test, results)), runs=len(results))
    assert figure.values is not None
    values = [SCALES[figure.unit] * value for value in figure.values(runs)]
    if figure.percentile is not None and values:
        values = [float(np.percentile(values, figure.percentile))]
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
