"""Table 4.10: what training a local map's two self-organizing maps costs, and how well they fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..campaign.kinds import LOCAL
from ..campaign.plan import Outcome, Plan
from .published import SOM_TRAINING
from .summary import Summary, summarize

METRIC_LIMIT, PERCEPTUAL_LIMIT = 0.002, 0.003
"""Seconds that training may take under profile `default`."""


@dataclass(frozen=True, slots=True)
class TrainingRow:
    """One configuration of one SOM over all local maps that were measured.

    figures: steps, seconds, quantization_error (in mm for metric SOMs, else a Euclidean distance of
    luminances), units_used.
    """

    configuration: str
    som: str
    figures: Mapping[str, Summary]
    published: str

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        ends = ("mean", "least", "greatest")
        return {
            "configuration": self.configuration,
            "som": self.som,
            "local_maps": self.figures["steps"].count,
            "published": self.published,
            **{name: {end: getattr(of, end) for end in ends} for name, of in self.figures.items()},
        }


def training_rows(plan: Plan, outcome: Outcome) -> list[TrainingRow]:
    """The rows of table 4.10, over the runs that trained every configuration."""
    trained: list[dict[str, dict[str, Any]]] = [
        one
        for world in plan.environments
        for result in outcome.of(LOCAL, world, "default")
        for one in result["trained"]
    ]
    names = list(dict.fromkeys(name for one in trained for name in one))
    return [_row(name, [one[name] for one in trained if name in one]) for name in names]


def _row(name: str, found: Sequence[dict[str, Any]]) -> TrainingRow:
    configuration, som = name.split(", ", 1)
    scale = 1000 * float(found[0].get("unit", 0.001)) if som.startswith("metric") else 1.0

    def summary(key: str, factor: float = 1.0) -> Summary:
        summed = summarize([factor * float(one[key]) for one in found])
        assert summed is not None  # there is at least one
        return summed

    figures = {
        "steps": summary("steps"),
        "seconds": summary("seconds"),
        "quantization_error": summary("error", scale),
        "units_used": summary("used"),
    }
    return TrainingRow(configuration, som, figures, _published(configuration, som))


def _published(configuration: str, som: str) -> str:
    if configuration == "batch" or som not in ("metric", "perceptual"):
        return ""
    column = int(configuration[-1]) - 1
    least, greatest = (SOM_TRAINING[f"{som}, iterations, {end}"][column] for end in ("least", "greatest"))
    seconds = SOM_TRAINING[f"{som}, time, mean (s)"][column]
    return f"{least:.0f} to {greatest:.0f} steps, {seconds:g} s"


def training_reached(rows: Sequence[TrainingRow]) -> dict[str, bool]:
    """By SOM: whether the batch training keeps its time and fits better than both configurations."""
    reached = {}
    for som, limit in (("metric", METRIC_LIMIT), ("perceptual", PERCEPTUAL_LIMIT)):
        by_name = {row.configuration: row for row in rows if row.som == som}
        if len(by_name) == 3:
            ours = by_name.pop("batch")
            others = min(row.figures["quantization_error"].mean for row in by_name.values())
            figures = ours.figures
            in_time = figures["seconds"].mean <= limit
            reached[som] = in_time and figures["quantization_error"].mean < others
    return reached
