"""The top of a report: what was run, which targets were reached, what was lost, what was not reproduced."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial

from ..campaign.campaign import Result
from ..campaign.kinds import ENVIRONMENTS, GLOBAL, KINDS, LOCAL
from ..campaign.plan import Outcome, Plan
from ..results.published import PUBLISHED
from ..results.rows import Row
from ..results.summary import markdown_table
from ..results.tables import of_runs

_MOST = 40
"""Lost runs that are listed one by one."""


def verdict(rows: Mapping[str, Sequence[Row]], training: Mapping[str, bool], plan: Plan) -> str:
    """How many targets are reached and figures reproduced, and which are not. rows: by table."""
    every = [(number, row) for number, found in rows.items() for row in found]
    parts = []
    if "default" in plan.profiles:
        judged = [(number, row) for number, row in every if row.reached is not None]
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
        compared = [(number, row) for number, row in every if row.reproduced is not None]
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
    for kind in (kind for kind in KINDS if kind in plan.kinds):
        for profile in plan.profiles:
            planned = plan.runs_of(kind, profile)
            cells = [f"{len(outcome.of(kind, world, profile))} of {planned}" for world in plan.environments]
            mean = cost(plan, outcome, kind, profile)
            lines.append([KINDS[kind], profile, *cells, "" if mean is None else f"{mean:.0f}"])
    return markdown_table(header, lines)


def cost(plan: Plan, outcome: Outcome, kind: str, profile: str) -> float | None:
    """Simulated seconds a run, on average over all environments."""
    found = [result for world in plan.environments for result in outcome.of(kind, world, profile)]
    return sum(float(result["sim_time_s"]) for result in found) / len(found) if found else None


def lost_runs(plan: Plan, outcome: Outcome) -> str:
    """The runs of profile `default` that did not do all they were to, with what they said."""
    if "default" not in plan.profiles:
        return ""
    lines = [
        f"- {KINDS[kind]}, {world}, seed {job.settings['seed']}: {why}"
        for kind in KINDS
        for world in plan.environments
        for job, result in outcome.runs(kind, world, "default")
        if (why := _failure(result))
    ]
    if not lines:
        return "No run of profile `default` was lost, gave up or closed a loop wrongly."
    more = [f"- and {len(lines) - _MOST} more"] if len(lines) > _MOST else []
    return "Runs of profile `default` that did not do all they were to:\n\n" + "\n".join(
        [*lines[:_MOST], *more]
    )


def _failure(result: Result) -> str:
    if "completed" in result:
        return "" if result["completed"] else str(result.get("lost", "lost"))
    if result.get("loop_correct") is False:
        return "closed its loop at the wrong place"
    return "" if result["finished"] else str(result.get("reason", "did not get round"))


def remark(number: str, plan: Plan, outcome: Outcome) -> str:
    """What there is to say of a table as a whole; "" for most."""
    if number == "4.3":
        return _mean_drift(plan, outcome)
    return _against_global(plan, outcome) if number == "4.6" else ""


def _mean_cm(outcome: Outcome, kind: str, name: str, world: str, profile: str) -> float | None:
    """Mean (cm) of a length (m) of the runs that got round."""
    found = of_runs(kind, name)(partial(outcome.runs, environment=world, profile=profile))
    return math.fsum(100.0 * value for value in found) / len(found) if found else None


def _mean_drift(plan: Plan, outcome: Outcome) -> str:
    """Table 4.3's mean over the environments: the noise preset is to keep it."""
    published = math.fsum(value or 0.0 for value in PUBLISHED["4.3"].figures["position error"].mean) / 3
    parts = []
    for profile in plan.profiles:
        means = [
            mean
            for world in ENVIRONMENTS
            if (mean := _mean_cm(outcome, GLOBAL, "path_integration_error_m", world, profile)) is not None
        ]
        if len(means) == len(ENVIRONMENTS):
            mean = math.fsum(means) / len(means)
            kept = "within" if abs(mean - published) <= 0.15 * published else "**not** within"
            parts.append(f"{mean:.0f} cm with profile `{profile}` ({kept} 15 %)")
    return f"Mean over the environments, published {published:.0f} cm: {'; '.join(parts)}." if parts else ""


def _against_global(plan: Plan, outcome: Outcome) -> str:
    """Whether local maps make the map of profile `default` any worse."""
    parts = []
    for world in plan.environments:
        without, with_local = (
            _mean_cm(outcome, kind, "position_error_m", world, "default") for kind in (GLOBAL, LOCAL)
        )
        if without is not None and with_local is not None:
            parts.append(f"{world} {with_local - without:+.2f} cm")
    what = "Position error of profile `default` with local maps, less that without: "
    return f"{what}{', '.join(parts)}." if parts else ""
