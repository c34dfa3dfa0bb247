"""The tables of chapter 4 as data: what of the runs each figure is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..campaign.campaign import Job, Result
from ..campaign.kinds import CORRECTED, GLOBAL, LOCAL, REFERENCE, UNCORRECTED

Runs = Callable[[str], Sequence[tuple[Job, Result]]]
"""The runs of a kind, in one environment and profile."""
Values = Callable[[Runs], list[float]]
"""Values of those runs, in m, rad, or without a unit."""
Test = Callable[[Result], bool]
SCALES = {"cm": 100.0, "deg": 180.0 / math.pi, "%": 100.0, "": 1.0}
"""What values are multiplied by for a unit."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A row of a table in each environment: a summary of `values`, or how many runs of a kind pass a test.

    published: its name in the published table. wanted: the share of runs that is the target of a count.
    only: the profile that has it, if not both. percentile: that one of the values, instead of all.
    """

    name: str
    unit: str
    values: Values | None = None
    published: str = ""
    counted: tuple[str, Test] | None = None
    wanted: float | None = None
    only: str = ""
    percentile: float | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """One table of the report."""

    number: str
    title: str
    figures: Sequence[Figure]


def is_true(name: str) -> Test:
    """Tests whether a run's result says so."""
    return lambda result: bool(result[name])


def of_runs(kind: str, name: str, keep: Test = lambda result: bool(result.get("finished", True))) -> Values:
    """A value of each run that got round (`finished`), or that passes `keep`."""
    return lambda runs: [
        float(result[name]) for _, result in runs(kind) if keep(result) and result[name] is not None
    ]


def of_nodes(kind: str, name: str, column: int | None = None, nodes: slice = slice(None)) -> Values:
    """A list's values of all runs together, or of some nodes; one column of it where it holds pairs."""

    def value(item: Any) -> float:
        return float(item if column is None else item[column])

    return lambda runs: [value(item) for _, result in runs(kind) for item in result[name][nodes]]


def off_reference(kind: str) -> Values:
    """Distance round (m) against that of a noise-free run along the right wall, as table 4.2 was published.

    The thesis has one "approximate actual distance" an environment for the runs of both sides.
    """

    def values(runs: Runs) -> list[float]:
        free = [
            float(result["loop_distance_m"])
            for job, result in runs(REFERENCE)
            if job.settings["side"] == "right" and result["finished"]
        ]
        return [
            abs(float(result["loop_distance_m"]) - actual)
            for actual in free[:1]
            for _, result in runs(kind)
            if result["finished"]
        ]

    return values


def _round_trip(kind: str) -> tuple[Figure, ...]:
    return (
        Figure("position error", "cm", of_runs(kind, "position_error_m"), "position error"),
        Figure("distance against the noise-free run", "cm", off_reference(kind), "position error"),
        Figure("largest error of an arc", "cm", of_runs(kind, "largest_arc_error_m")),
        Figure("true distance round", "cm", of_runs(kind, "true_loop_distance_m"), "true loop"),
        Figure("nodes", "", of_runs(kind, "nodes")),
        Figure("got round", "runs", counted=(kind, is_true("finished")), wanted=1.0),
    )


def _explored() -> tuple[Figure, ...]:
    position, heading = ("position error", "cm", 0), ("heading error", "deg", 1)
    strategies = (("rows", slice(0, None, 2)), ("columns", slice(1, None, 2)))
    return (
        *(
            Figure(f"{what} after exploring", unit, of_nodes(LOCAL, "explored", column), what)
            for what, unit, column in (position, heading)
        ),
        *(
            Figure(f"{what}, explored by {strategy}", unit, of_nodes(LOCAL, "explored", column, nodes))
            for strategy, nodes in strategies
            for what, unit, column in (position, heading)
        ),
        *(
            Figure(f"{what} when driving on", unit, of_nodes(LOCAL, "docked", column))
            for what, unit, column in (position, heading)
        ),
        Figure("local maps", "", of_runs(LOCAL, "local_maps"), "local maps"),
    )


def _loop_closing() -> tuple[Figure, ...]:
    def at_threshold(name: str, how: str) -> Test:
        """What eq. 3.33 would have made of a run at a threshold."""
        return lambda result: bool(result["closing"].get(name, "missed") == how)

    def by_corners(how: str) -> Test:
        return lambda result: {True: "right", False: "wrong", None: "missed"}[result["loop_correct"]] == how

    outcomes = ("right", "wrong", "missed")
    return (
        *(
            Figure(
                f"{name}, {how}",
                "runs",
                None,
                f"{name}, {how}",
                (LOCAL, at_threshold(name, how)),
                None,
                "thesis",
            )
            for name in ("T1", "T2", "T3")
            for how in outcomes
        ),
        *(
            Figure(
                f"corners, {how}",
                "runs",
                counted=(LOCAL, by_corners(how)),
                wanted=1.0 if how == "right" else None,
                only="default",
            )
            for how in outcomes
        ),
    )


_HEADINGS = of_nodes(CORRECTED, "headings")
_COMPLETED = (CORRECTED, is_true("completed"))
_END_OF_COMPLETED = of_runs(CORRECTED, "end_error_m", is_true("completed"))
TABLES = (
    Table("4.2", "Global maps alone: distance once round", _round_trip(GLOBAL)),
    Table(
        "4.3",
        "Path integration: error after one loop",
        [
            Figure(
                "path integration error", "cm", of_runs(GLOBAL, "path_integration_error_m"), "position error"
            )
        ],
    ),
    Table("4.5", "Local maps: error after exploring one", _explored()),
    Table("4.6", "Global maps with local maps: distance once round", _round_trip(LOCAL)),
    Table(
        "4.12",
        "Five traversals, not corrected by views",
        [
            Figure("position error at the end", "cm", of_runs(UNCORRECTED, "end_error_m"), "distance error"),
            Figure("growth a traversal", "cm", of_runs(UNCORRECTED, "slope_m")),
            Figure("driven to the end", "runs", counted=(UNCORRECTED, is_true("driven"))),
            Figure("never lost", "runs", counted=(UNCORRECTED, is_true("completed"))),
        ],
    ),
    Table(
        "4.14",
        "Five traversals, corrected: runs completed",
        [Figure("completed", "runs", published="completed", counted=_COMPLETED, wanted=1.0)],
    ),
    Table(
        "4.15",
        "Five traversals, corrected: error at the end of the runs completed",
        [Figure("position error at the end", "cm", _END_OF_COMPLETED, "distance error")],
    ),
    Table(
        "4.16",
        "Position correction at the nodes",
        [
            Figure(
                "position error before correction", "cm", of_nodes(CORRECTED, "before"), "before correction"
            ),
            Figure("position error after correction", "cm", of_nodes(CORRECTED, "after"), "after correction"),
            Figure("heading error on local entry", "deg", _HEADINGS, "heading error"),
            Figure("heading error, 95th percentile", "deg", _HEADINGS, percentile=95.0),
            Figure("units of local maps reached", "%", of_runs(CORRECTED, "local_share")),
        ],
    ),
    Table("4.18", "Loop closing", _loop_closing()),
)
"""The tables whose rows have an environment each; 4.10 is made by `training`."""
