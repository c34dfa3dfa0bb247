"""Dry run: what a mission would do, and what is wrong with it as far as can be told without a robot."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ..containment import Watchdog
from ..containment import describe as describe_fault
from ..errors import MissionError
from .files import HANG
from .mission import Mission
from .step import Plan


def dry_run(
    mission: Mission, nodes: Sequence[int] | None = None, behaviors: Collection[str] | None = None
) -> Plan:
    """Goes through the mission as if every step succeeded.

    nodes: those of the map it will be run with; None: unknown. behaviors: the loaded ones; None: any.
    """
    plan = Plan(nodes, behaviors)
    try:
        with Watchdog(None, HANG):
            plan.body(mission.body, 0)
    except MissionError as fault:
        plan.problems.append(str(fault))
    except Exception as fault:
        plan.problems.append(f"the script raised {describe_fault(fault)}")
    if len(plan.lines) >= plan.limit:
        plan.lines.append(f"... (only the first {plan.limit} steps are shown)")
    return plan
