"""The top of a report: what was run, which targets were reached, what was lost, what was not reproduced."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..campaign.campaign import Result
from ..campaign.plan import CORRECTED, GLOBAL, LOCAL, REFERENCE, UNCORRECTED, Outcome, Plan
from ..campaign.summary import markdown_table
from .rows import Row

KINDS = {
    REFERENCE: "mapping without noise",
    GLOBAL: "mapping, no local maps",
    LOCAL: "mapping with local maps",
    UNCORRECTED: "five traversals, not corrected",
    CORRECTED: "five traversals, corrected, local maps driven",
}
"""What each kind of run is called."""
_MOST = 40
"""Lost runs that are listed one by one."""


def verdict(rows: Mapping[str, Sequence[Row]], training: Mapping[str, bool], plan: Plan) -> str:
    """How many targets are reached and figures reproduced, and which are not. rows: by table."""
    parts = []
    if "default" in plan.profiles:
        judged = [(number, row) for number, found in rows.items() for row in found if row.reached is not None]
        missed = [
            f"- {number} {row.figure}, {row.environment}: {_why(row)}"
            for number, row in judged
            if not row.reached
        ]
        missed += [f"- 4.10 {som} SOM: see the table" for som, done in training.items() if not done]
        total = len(judged) + len(training)
        parts.append(f"Profile `default` reaches **{total - len(missed)} of {total}** targets.")
        if missed:
            parts.append("Targets missed:\n\n" + "\n".join(missed))
    if "thesis" in plan.profiles:
        compared = [
            (number, row) for number, found in rows.items() for row in found if row.reproduced is not None
        ]
        apart = [
            f"{number} {row.figure}, {row.environment}" for number, row in compared if not row.reproduced
        ]
        parts.append(
            f"Profile `thesis`: {len(compared) - len(apart)} of {len(compared)} means lie within the "
            "published least and greatest value; why others do not is in [experiments.md](experiments.md)."
        )
        if apart:
            parts.append("Not reproduced: " + "; ".join(apart) + ".")
    return "\n\n".join(parts)


def _why(row: Row) -> str:
    found = row.measured["default"]
    if found.count is not None:
        return f"{found.count} of {found.runs}, wanted {row.target}"
    assert found.summary is not None
    return f"mean {found.summary.mean:.2f}, worst {found.summary.greatest:.2f}; target {row.target}"


def runs_made(plan: Plan, outcome: Outcome) -> str:
    """A table of the runs finished of those planned, and what one takes."""
    header = ["run", "profile", *plan.environments, "simulated s a run"]
    lines = []
    for kind in KINDS:
        if kind not in plan.kinds:
            continue
        for profile in plan.profiles:
            cells = [
                f"{len(outcome.of(kind, world, profile))} of {plan.runs_of(kind, profile)}"
                for world in plan.environments
            ]
            mean = cost(plan, outcome, kind, profile)
            lines.append([KINDS[kind], profile, *cells, "" if mean is None else f"{mean:.0f}"])
    return markdown_table(header, lines)


def cost(plan: Plan, outcome: Outcome, kind: str, profile: str) -> float | None:
    """Simulated seconds a run, on average over all environments."""
    times = [
        float(result["sim_time_s"])
        for world in plan.environments
        for result in outcome.of(kind, world, profile)
    ]
    return sum(times) / len(times) if times else None


def lost_runs(plan: Plan, outcome: Outcome) -> str:
    """The runs of profile `default` that did not do all they were to, with what they said."""
    if "default" not in plan.profiles:
        return ""
    lines = [
        f"- {KINDS[kind]}, {world}, seed {seed}: {why}"
        for kind in KINDS
        for world in plan.environments
        for seed, why in _failed(outcome, kind, world)
    ]
    if not lines:
        return "No run of profile `default` was lost, gave up or closed a loop wrongly."
    more = [f"- and {len(lines) - _MOST} more"] if len(lines) > _MOST else []
    return "Runs of profile `default` that did not do all they were to:\n\n" + "\n".join(
        [*lines[:_MOST], *more]
    )


def _failed(outcome: Outcome, kind: str, world: str) -> Iterator[tuple[Any, str]]:
    key = (kind, world, "default")
    for job, result in zip(outcome.jobs.get(key, []), outcome.of(*key), strict=True):
        why = _failure(result)
        if why:
            yield job.settings["seed"], why


def _failure(result: Result) -> str:
    if "completed" in result:
        return "" if result["completed"] else str(result.get("lost", "lost"))
    if result.get("loop_correct") is False:
        return "closed its loop at the wrong place"
    return "" if result["finished"] else str(result.get("reason", "did not get round"))
