"""What studies say of a set of runs: one figure each of maps and of the trips over them, with its limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..campaign.campaign import Result
from .published import PUBLISHED
from .summary import markdown_table, summarize
from .targets import TARGETS


@dataclass(frozen=True, slots=True)
class Runs:
    """Results of the same kind of runs: maps, traversals not corrected, traversals corrected."""

    maps: Sequence[Result] = ()
    uncorrected: Sequence[Result] = ()
    corrected: Sequence[Result] = ()

    @property
    def trips(self) -> list[Result]:
        """All traversals."""
        return [*self.uncorrected, *self.corrected]

    @property
    def collisions(self) -> int:
        """Ticks in which the shell touched something, in all runs."""
        return sum(int(run["collisions"]) for run in (*self.maps, *self.trips))


@dataclass(frozen=True, slots=True)
class Score:
    """One figure. values: all of it, in its unit. target: table and figure it is held against."""

    name: str
    values: Callable[[Runs], list[float]]
    target: tuple[str, str] = ("", "")
    published: str = ""

    def limit(self, environment: int) -> float | None:
        """What the mean may be in harder conditions: a third of the margin over the published given up."""
        target, table = TARGETS.get(self.target), PUBLISHED.get(self.target[0])
        if target is None or target.mean is None:
            return None
        own = target.mean[environment]
        there = table.figures[self.published].mean[environment] if table and self.published else None
        return own if there is None else own + max(0.0, there - own) / 3.0


def _of_maps(name: str) -> Callable[[Runs], list[float]]:
    return lambda runs: [100.0 * float(run[name]) for run in runs.maps if run["finished"]]


def _explored(column: int, scale: float) -> Callable[[Runs], list[float]]:
    return lambda runs: [scale * float(pair[column]) for run in runs.maps for pair in run["explored"]]


def _ends(runs: Sequence[Result]) -> list[float]:
    return [100.0 * float(run["end_error_m"]) for run in runs if run["completed"]]


_DEGREES = 180.0 / math.pi
_POSITION, _HEADING, _END = "position error", "heading error", "distance error"
SCORES = (
    Score("map error (cm)", _of_maps("position_error_m"), ("4.6", "position error"), _POSITION),
    Score("after exploring (cm)", _explored(0, 100.0), ("4.5", "position error after exploring"), _POSITION),
    Score(
        "after exploring (deg)", _explored(1, _DEGREES), ("4.5", "heading error after exploring"), _HEADING
    ),
    Score(
        "end, not corrected (cm)",
        lambda runs: _ends(runs.uncorrected),
        ("4.12", "position error at the end"),
        _END,
    ),
    Score(
        "end, corrected (cm)", lambda runs: _ends(runs.corrected), ("4.15", "position error at the end"), _END
    ),
    Score(
        "heading on entry (deg)",
        lambda runs: [_DEGREES * float(turn) for run in runs.corrected for turn in run["headings"]],
        ("4.16", "heading error on local entry"),
        _HEADING,
    ),
)
"""The figures of targets that mapping and traversals have; lost runs are counted apart."""


def closing(run: Result) -> str:
    """How a mapping ended: "right", "wrong", "ambiguous" (said so, closed nothing) or "missed"."""
    if run["loop_correct"] is not None:
        return "right" if run["loop_correct"] else "wrong"
    return "ambiguous" if "ambiguous" in str(run["reason"]) else "missed"


def driven(runs: Sequence[Result]) -> str:
    """How many traversal runs were completed, as text."""
    return f"{sum(bool(run['completed']) for run in runs)} of {len(runs)}" if runs else "none"


def closed(runs: Sequence[Result]) -> str:
    """How many mappings closed their loop rightly, and what the others did, as text."""
    found = [closing(run) for run in runs]
    others = [f"{found.count(what)} {what}" for what in ("wrong", "ambiguous", "missed") if what in found]
    return ", ".join([f"{found.count('right')} of {len(found)}", *others]) if runs else "none"


def cell(values: Sequence[float]) -> str:
    """Mean and worst as text."""
    found = summarize(list(values))
    return "none" if found is None else f"{found.mean:.2f} ({found.greatest:.2f})"


def kept(runs: Runs, environment: int) -> list[str]:
    """The names of what is beyond its limit, lost runs and wrong closures included."""
    missed = []
    if any(closing(run) not in ("right", "ambiguous") for run in runs.maps):
        missed.append("loop closing")
    if any(not run["completed"] for run in runs.trips):
        missed.append("runs lost")
    for score in SCORES:
        limit, values = score.limit(environment), score.values(runs)
        if limit is not None and values and math.fsum(values) / len(values) > limit:
            missed.append(score.name)
    return missed


def score_values(runs: Runs) -> dict[str, Any]:
    """All scores as JSON values."""
    return {
        "maps": len(runs.maps),
        "closing": [closing(run) for run in runs.maps],
        "completed": [bool(run["completed"]) for run in runs.corrected],
        "completed uncorrected": [bool(run["completed"]) for run in runs.uncorrected],
        "collisions": runs.collisions,
        "scores": {score.name: score.values(runs) for score in SCORES},
    }


def runs_table(
    first: str,
    found: Mapping[str, Runs],
    scores: Sequence[str],
    columns: Mapping[str, Callable[[str, Runs], str]],
    left_out: Sequence[tuple[str, str]] = (),
) -> str:
    """A Markdown table, a line a name of `found`: how loops were closed, scores, and the study's own columns.

    first: what the names are. left_out: cells (name, score) that would say nothing.
    """
    shown = [score for score in SCORES if score.name in scores]
    header = [first, "closed rightly", *(score.name for score in shown), *columns]
    lines = [
        [
            name,
            closed(runs.maps),
            *("" if (name, score.name) in left_out else cell(score.values(runs)) for score in shown),
            *(column(name, runs) for column in columns.values()),
        ]
        for name, runs in found.items()
    ]
    return markdown_table(header, lines)


def with_failures(parts: Sequence[str], *found: Mapping[str, Runs]) -> str:
    """The parts of a section, and a list of the runs that did not do what they were to, if there are any."""
    lost = [line for group in found for name, runs in group.items() for line in _failures(name, runs)]
    told = ["Runs that did not do all they were to:\n\n" + "\n".join(lost)] if lost else []
    return "\n\n".join([*parts, *told])


def _failures(label: str, runs: Runs) -> list[str]:
    """Lines that say which runs did not do what they were to, and why."""
    lines = [
        f"- {label}, mapping, seed {run['seed']}: {run['reason']} ({closing(run)})"
        for run in runs.maps
        if closing(run) != "right"
    ]
    for what, group in (("not corrected", runs.uncorrected), ("corrected", runs.corrected)):
        lines += [f"- {label}, traversals {what}: {run['lost']}" for run in group if not run["completed"]]
    return lines
