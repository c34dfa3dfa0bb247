"""The report on the tables: the verdict, the runs there are, what was lost."""

import json
import re
from collections.abc import Callable
from typing import Any

from tolman.scripts.experiments.campaign.kinds import GLOBAL
from tolman.scripts.experiments.campaign.plan import Outcome, Plan
from tolman.scripts.experiments.report.text import report_text, report_values
from tolman.scripts.plain import plain

WORLD = "env1"
Make = Callable[..., Any]


def test_the_report_names_the_targets_that_were_missed_and_the_seeds(mapping: Make, outcome: Make) -> None:
    plan = Plan(("table-4.2",), 2, 2, 2000, (WORLD,), ("default",))
    text = report_text(plan, outcome(GLOBAL, "default", [mapping(0.0), mapping(0.3)]), {"map": "1"})
    assert "- 4.2 position error, env1: mean 15.00, worst 30.00; target mean ≤ 1, worst ≤ 4" in text
    assert "Seeds 2000 to 2001" in text
    assert "Version of the code by kind of run: map 1." in text


def test_the_report_counts_targets_and_lists_lost_runs_with_their_reasons(
    mapping: Make, outcome: Make
) -> None:
    plan = Plan(("table-4.2",), 2, 2, 2000, (WORLD,), ("default",))
    lost = mapping(9.0, finished=False, reason="3 rounds without recognizing a corner")
    text = report_text(
        plan, outcome(GLOBAL, "default", [mapping(0.0), lost]), {"map": "1"}, notes="It was dark."
    )
    assert "reaches **2 of 3** targets" in text
    assert "- mapping, no local maps, env1, seed 1: 3 rounds without recognizing a corner" in text
    assert "It was dark." in text


def test_the_report_of_an_unfinished_campaign_says_how_much_of_it_there_is(
    mapping: Make, outcome: Make
) -> None:
    plan = Plan(("table-4.2",), 20, 50, 2000, (WORLD,), ("default",))
    text = report_text(plan, outcome(GLOBAL, "default", [mapping(0.0)] * 3), {"map": "1"})
    assert re.search(r"mapping, no local maps *\| *default *\| *3 of 50 *\| *100 *\|", text)


def test_the_report_can_be_written_as_json_even_where_nothing_was_run() -> None:
    plan = Plan(("table-4.2", "table-4.10", "table-4.16"), 2, 2, 2000, (WORLD,))
    values = plain(report_values(plan, Outcome(), {"map": "1"}))
    assert json.loads(json.dumps(values, allow_nan=False))["tables"]["4.10"] == []
    assert "none" in report_text(plan, Outcome(), {"map": "1"})
