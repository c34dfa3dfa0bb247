"""`tolman run`: runs a mission, or shows what it would do."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ....files.messages import printable
from ..command import Command
from ..live import add_live, watched
from ..options import add_force, add_robot, add_simulation, check_robot, number, pose, request_of
from ..output import check_input, check_output, print_json, progress_line, stdout_to_stderr

if TYPE_CHECKING:
    from ...session.requests import MissionRequest

DESCRIPTION = """Runs a mission: a Python file with a generator function `mission`, or a YAML file of steps.
See docs/missions.md for the steps, and scripts/missions/ for examples.

The world is the map's unless --world names one. With --journal a mission that was interrupted goes on with
--resume after its last completed step."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman run`."""
    parser.add_argument("mission", type=Path, metavar="MISSION", help="the mission's .py or .yaml file")
    parser.add_argument("--map", type=Path, metavar="FILE", help="the map to begin with")
    parser.add_argument("--world", metavar="WORLD", help="where it runs; default: the map's world")
    parser.add_argument(
        "--start", type=pose, metavar="X,Y,HEADING", help="where the robot begins (m, m, degrees)"
    )
    parser.add_argument("--dry-run", action="store_true", help="print the steps and do nothing")
    parser.add_argument("--global-only", action="store_true", help="explore without local maps")
    parser.add_argument(
        "--max-time", type=number(0, strictly=True), metavar="S", help="cancel after S simulated seconds"
    )
    parser.add_argument("--journal", type=Path, metavar="FILE", help="keep completed steps there")
    parser.add_argument("--resume", action="store_true", help="go on from the --journal")
    parser.add_argument("--record", type=Path, metavar="RUN", help="record the run, for replay and explain")
    add_force(parser)
    add_live(parser)
    add_simulation(parser)
    add_robot(parser)


def run(options: argparse.Namespace) -> int:
    """Runs or shows the mission. Status 1: it failed, was cancelled, or the dry run found problems."""
    check_robot(options)
    check_input(options.mission, "mission")
    if options.map is not None:
        check_input(options.map, "map")
    from ...session.requests import MissionRequest

    request = request_of(MissionRequest, options)
    if options.dry_run:
        return _show(request, options.json)
    if options.journal is not None:
        check_output(
            options.journal, replace=options.resume or options.force, hint="--resume goes on with it"
        )
    if options.record is not None:
        check_output(options.record, replace=options.force)
    return _run(request, options.json, options.live)


def _show(request: MissionRequest, as_json: bool) -> int:
    from ....agent.missions.dry_run import dry_run
    from ....agent.missions.mission import Mission
    from ....maps.hybrid_map import HybridMap
    from ....plugins.discovery import discover

    with stdout_to_stderr():
        nodes = sorted(HybridMap.load(request.map).nodes()) if request.map is not None else None
        plan = dry_run(
            Mission.load(request.mission), nodes, set(discover(request.plugins, request.isolate).plugins())
        )
    if as_json:
        print_json({"steps": plan.lines, "problems": plan.problems})
    else:
        print("\n".join(map(printable, plan.lines)))
        for problem in plan.problems:
            print(f"problem: {printable(problem)}")
    return 1 if plan.problems else 0


def _run(request: MissionRequest, as_json: bool, live: int | None) -> int:
    from ...session.simulation import run_mission

    with progress_line() as line, watched(live) as watch:

        def say(text: str) -> None:
            line.close()
            print(printable(text), file=sys.stderr, flush=True)

        report = run_mission(request, line.simulated, say, watch)
    if as_json:
        print_json(report.to_json())
    else:
        reason = f": {report.reason}" if report.reason else ""
        print(printable(f"{report.mission}: {report.status}{reason}"))
        if report.result is not None:
            print(printable(f"result: {report.result}"))
        print(f"{report.steps_done} steps, {report.sim_time_s:.0f} s simulated")
    return 0 if report.status == "done" else 1


COMMAND = Command("run", DESCRIPTION, add_arguments, run)
