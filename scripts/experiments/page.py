"""A page of results: the tables and studies that were asked for, run and put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .campaign.campaign import Job
from .campaign.plan import Outcome, Plan
from .campaign.running import Running, versions
from .campaign.thesis_runs import run_plan
from .report.text import MADE, SIMULATED, report_text, report_values, tuned, versions_text
from .studies.ablation import ABLATION
from .studies.beyond import BEYOND
from .studies.drawn_rooms import SHAPED, UNSEEN
from .studies.study import Asked, Results, Study, run_study
from .studies.variants import VARIANTS

STUDIES: Mapping[str, Study] = MappingProxyType(
    {study.name: study for study in (VARIANTS, ABLATION, UNSEEN, SHAPED, BEYOND)}
)
"""What there is beyond the thesis's tables, by name."""


@dataclass(slots=True)
class Page:
    """What is asked for, and after `run` what came of it. folder: the work folder; notes: for the summary."""

    plan: Plan
    studies: Sequence[Study]
    asked: Asked
    folder: Path
    notes: str = ""
    outcome: Outcome = field(default_factory=Outcome)
    results: dict[str, Results] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)

    def run(self, running: Running) -> None:
        """Runs what the work folder does not have yet. Raises: CampaignError.

        A run that raises an error is left out and named in `errors`.
        """
        running = replace(running, failed=self._note_error)
        if self.plan.tables:
            self.outcome = run_plan(self.plan, self.folder, running)
        for study in self.studies:
            self.results[study.name] = run_study(study, self.asked, self.folder, running)

    def _note_error(self, job: Job, error: str) -> None:
        told = ", ".join(f"{name} {value}" for name, value in job.settings.items())
        self.errors.append(f"{error} ({told})")

    def text(self, pictures: Sequence[tuple[str, str]] = ()) -> str:
        """The page in Markdown. pictures: of the tables, each a title and a path relative to the page."""
        parts = []
        if self.plan.tables:
            parts.append(report_text(self.plan, self.outcome, versions(), pictures, self.notes))
        else:
            first = self.asked.first_seed
            parts += ["# Results beyond the thesis", f"{MADE} {SIMULATED}"]
            parts += [f"Seeds from {first}; {tuned(first)}", versions_text(versions()), self.notes]
        for study in self.studies:
            report = study.report(self.asked, self.results.get(study.name, {}))
            parts.append(f"## {study.title}\n\n{report}\n")
        if self.errors:
            listed = "\n".join(f"- {error}" for error in self.errors)
            parts.append(f"## Errors\n\nRuns that ended in an error of the program:\n\n{listed}")
        return "\n\n".join(part.strip() for part in parts if part) + "\n"

    def values(self) -> dict[str, Any]:
        """The page as JSON values."""
        values = report_values(self.plan, self.outcome, versions()) if self.plan.tables else {}
        found = {
            study.name: study.values(self.asked, self.results.get(study.name, {})) for study in self.studies
        }
        return {**values, "studies": found} if found else values
