"""The tables of chapter 4 as data: what of the runs each figure is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ..campaign.campaign import Result
from ..campaign.plan import CORRECTED, ENVIRONMENTS, GLOBAL, LOCAL, REFERENCE, UNCORRECTED, Outcome, Plan
from .published import PUBLISHED
from .rows import Figure, Share, Table, Values


def of_runs(
    kind: str, name: str, scale: float = 1.0, *, only: Callable[[Result], bool] | None = None
) -> Values:
    """A value of each run that got round (`finished`), or that passes `only`."""

    def values(outcome: Outcome, world: str, profile: str) -> list[float]:
        keep = only or (lambda result: bool(result.get("finished", True)))
        chosen = [result[name] for result in outcome.of(kind, world, profile) if keep(result)]
        return [scale * float(value) for value in chosen if value is not None]

    return values


def of_nodes(
    kind: str, name: str, scale: float, column: int | None = None, nodes: slice = slice(None)
) -> Values:
    """A list's values of all runs together, or of some nodes; one column of it where it holds pairs."""

    def values(outcome: Outcome, world: str, profile: str) -> list[float]:
        lists = (result[name] for result in outcome.of(kind, world, profile))
        return [
            scale * float(item if column is None else item[column])
            for items in lists
            for item in items[nodes]
        ]

    return values


def percentile(inner: Values, percent: float) -> Values:
    """One percentile of other values, as a single value."""

    def values(outcome: Outcome, world: str, profile: str) -> list[float]:
        found = inner(outcome, world, profile)
        return [float(np.percentile(found, percent))] if found else []

    return values


def counted(kind: str, test: Callable[[Result], bool]) -> Share:
    """How many runs of a kind pass a test."""

    def share_of(outcome: Outcome, world: str, profile: str) -> tuple[int, int]:
        results = outcome.of(kind, world, profile)
        return sum(map(test, results)), len(results)

    return share_of


def off_reference(kind: str) -> Values:
    """Distance round (cm) against that of a noise-free run along the right wall, as table 4.2 was published.

    The thesis has one "approximate actual distance" an environment for the runs of both sides.
    """

    def values(outcome: Outcome, world: str, profile: str) -> list[float]:
        actual = next(
            (
                float(result["loop_distance_m"])
                for job, result in _pairs(outcome, (REFERENCE, world, profile))
                if job.settings["side"] == "right" and result["finished"]
            ),
            None,
        )
        if actual is None:
            return []
        return [
            100 * abs(float(result["loop_distance_m"]) - actual)
            for result in outcome.of(kind, world, profile)
            if result["finished"]
        ]

    return values


def _pairs(outcome: Outcome, key: tuple[str, str, str]) -> Iterable[tuple[Any, Result]]:
    return zip(outcome.jobs.get(key, []), outcome.results.get(key, []), strict=True)


def _closed(result: Result, outcome: str) -> bool:
    """How profile `default` closed its loop."""
    found = {True: "right", False: "wrong", None: "missed"}[result["loop_correct"]]
    return found == outcome


_ERROR = ("position error, mean", "position error, least", "position error, greatest")
_END = ("distance error, mean", "distance error, least", "distance error, greatest")
_DEGREES = 180.0 / math.pi


def _round_trip(kind: str) -> tuple[Figure, ...]:
    return (
        Figure("position error", "cm", of_runs(kind, "position_error_m", 100), published=_ERROR),
        Figure("distance against the noise-free run", "cm", off_reference(kind), published=_ERROR),
        Figure("largest error of an arc", "cm", of_runs(kind, "largest_arc_error_m", 100)),
        Figure(
            "true distance round",
            "cm",
            of_runs(kind, "true_loop_distance_m", 100),
            published=("true loop", "", ""),
        ),
        Figure("nodes", "", of_runs(kind, "nodes")),
        Figure(
            "got round", "runs", counted=counted(kind, lambda result: bool(result["finished"])), wanted=1.0
        ),
    )


def _thresholds() -> tuple[Figure, ...]:
    return tuple(
        Figure(
            f"{name}, {what}",
            "runs",
            counted=counted(LOCAL, _would_close(name, what)),
            published=(f"{name}, {what}", "", ""),
            only="thesis",
        )
        for name in ("T1", "T2", "T3")
        for what in ("right", "wrong", "missed")
    )


def _would_close(threshold: str, outcome: str) -> Callable[[Result], bool]:
    """Tests what eq. 3.33 would have made of a run at a threshold."""

    def test(result: Result) -> bool:
        return bool(result["closing"].get(threshold, "missed") == outcome)

    return test


def _mean_of_three(plan: Plan, outcome: Outcome) -> str:
    """Table 4.3's mean over the environments: the noise preset is to keep it."""
    if len(plan.environments) < len(ENVIRONMENTS):
        return ""
    parts = []
    for profile in plan.profiles:
        means = [
            math.fsum(found) / len(found)
            for world in plan.environments
            if (found := of_runs(GLOBAL, "path_integration_error_m", 100)(outcome, world, profile))
        ]
        if len(means) == len(ENVIRONMENTS):
            mean = math.fsum(means) / len(means)
            kept = "within" if abs(mean - _PUBLISHED_DRIFT) <= 0.15 * _PUBLISHED_DRIFT else "**not** within"
            parts.append(f"{mean:.0f} cm with profile `{profile}` ({kept} 15 %)")
    published = f"Mean over the environments, published {_PUBLISHED_DRIFT:.0f} cm: "
    return published + "; ".join(parts) + "." if parts else ""


_PUBLISHED_DRIFT = (
    math.fsum(value or 0.0 for value in PUBLISHED["4.3"].figures["position error, mean"].values) / 3
)


def _against_global(plan: Plan, outcome: Outcome) -> str:
    """Whether local maps make the map of profile `default` any worse."""
    parts = []
    for world in plan.environments:
        one, other = (
            of_runs(kind, "position_error_m", 100)(outcome, world, "default") for kind in (GLOBAL, LOCAL)
        )
        if one and other:
            change = math.fsum(other) / len(other) - math.fsum(one) / len(one)
            parts.append(f"{world} {change:+.2f} cm")
    return (
        "Position error of profile `default` with local maps, less that without: " + ", ".join(parts) + "."
        if parts
        else ""
    )


TABLES = (
    Table("4.2", "Global maps alone: distance once round", _round_trip(GLOBAL)),
    Table(
        "4.3",
        "Path integration: error after one loop",
        (
            Figure(
                "path integration error",
                "cm",
                of_runs(GLOBAL, "path_integration_error_m", 100),
                published=_ERROR,
            ),
        ),
        remarks=(_mean_of_three,),
    ),
    Table(
        "4.5",
        "Local maps: error after exploring one",
        (
            Figure(
                "position error after exploring", "cm", of_nodes(LOCAL, "explored", 100, 0), published=_ERROR
            ),
            Figure(
                "heading error after exploring",
                "deg",
                of_nodes(LOCAL, "explored", _DEGREES, 1),
                published=("heading error, mean", "heading error, least", "heading error, greatest"),
            ),
            *(
                Figure(
                    f"{what}, explored by {strategy}", unit, of_nodes(LOCAL, "explored", scale, column, nodes)
                )
                for strategy, nodes in (("rows", slice(0, None, 2)), ("columns", slice(1, None, 2)))
                for what, unit, scale, column in (
                    ("position error", "cm", 100.0, 0),
                    ("heading error", "deg", _DEGREES, 1),
                )
            ),
            Figure("position error when driving on", "cm", of_nodes(LOCAL, "docked", 100, 0)),
            Figure("heading error when driving on", "deg", of_nodes(LOCAL, "docked", _DEGREES, 1)),
            Figure("local maps", "", of_runs(LOCAL, "local_maps"), published=("local maps, mean", "", "")),
        ),
    ),
    Table(
        "4.6",
        "Global maps with local maps: distance once round",
        _round_trip(LOCAL),
        remarks=(_against_global,),
    ),
    Table(
        "4.12",
        "Five traversals, not corrected by views",
        (
            Figure(
                "position error at the end",
                "cm",
                of_runs(UNCORRECTED, "end_error_m", 100),
                published=_END,
            ),
            Figure("growth a traversal", "cm", of_runs(UNCORRECTED, "slope_m", 100)),
            Figure("driven to the end", "runs", counted=counted(UNCORRECTED, lambda r: bool(r["driven"]))),
            Figure("never lost", "runs", counted=counted(UNCORRECTED, lambda r: bool(r["completed"]))),
        ),
    ),
    Table(
        "4.14",
        "Five traversals, corrected: runs completed",
        (
            Figure(
                "completed",
                "runs",
                counted=counted(CORRECTED, lambda r: bool(r["completed"])),
                published=("completed", "", ""),
                wanted=1.0,
            ),
        ),
    ),
    Table(
        "4.15",
        "Five traversals, corrected: error at the end of the runs completed",
        (
            Figure(
                "position error at the end",
                "cm",
                of_runs(CORRECTED, "end_error_m", 100, only=lambda r: bool(r["completed"])),
                published=_END,
            ),
        ),
    ),
    Table(
        "4.16",
        "Position correction at the nodes",
        (
            Figure(
                "position error before correction",
                "cm",
                of_nodes(CORRECTED, "before", 100),
                published=("before correction, mean", "", ""),
            ),
            Figure(
                "position error after correction",
                "cm",
                of_nodes(CORRECTED, "after", 100),
                published=("after correction, mean", "", ""),
            ),
            Figure(
                "heading error on local entry",
                "deg",
                of_nodes(CORRECTED, "headings", _DEGREES),
                published=("heading error, mean", "", ""),
            ),
            Figure(
                "heading error, 95th percentile",
                "deg",
                percentile(of_nodes(CORRECTED, "headings", _DEGREES), 95),
            ),
            Figure(
                "units of local maps reached",
                "%",
                of_runs(CORRECTED, "local_share", 100),
            ),
        ),
    ),
    Table(
        "4.18",
        "Loop closing",
        (
            *_thresholds(),
            Figure(
                "corners, right",
                "runs",
                counted=counted(LOCAL, lambda r: _closed(r, "right")),
                wanted=1.0,
                only="default",
            ),
            Figure(
                "corners, wrong",
                "runs",
                counted=counted(LOCAL, lambda r: _closed(r, "wrong")),
                only="default",
            ),
            Figure(
                "corners, missed",
                "runs",
                counted=counted(LOCAL, lambda r: _closed(r, "missed")),
                only="default",
            ),
        ),
    ),
)
"""The tables whose rows have an environment each; 4.10 is made by `training`."""
