"""`tolman go`: drives to a node of a saved map."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..command import Command
from ..live import add_live, watched
from ..options import add_robot, add_simulation, check_robot, node, number, pose, request_of
from ..output import check_input, check_output, print_json, progress_line

DESCRIPTION = """Loads a map and drives to one of its nodes. Without --from, --at or --lost the robot
starts where it was when the map was saved. The map is left as it is, unless --learn is given."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman go`."""
    parser.add_argument("map", type=Path, metavar="FILE", help="the map")
    parser.add_argument("--to", type=node, required=True, metavar="NODE", help="number or name of the node")
    start = parser.add_mutually_exclusive_group()
    start.add_argument(
        "--from", dest="origin", type=node, metavar="NODE", help="start at this node; the robot knows it"
    )
    start.add_argument(
        "--at", type=pose, metavar="X,Y,HEADING", help="start there (m, m, degrees); the robot is not told"
    )
    start.add_argument(
        "--lost",
        action="store_true",
        help="start anywhere on the boundary, as --seed says; the robot is not told",
    )
    parser.add_argument(
        "--world", metavar="WORLD", help="drive in this world instead of the one the map was made in"
    )
    parser.add_argument(
        "--max-time", type=number(0, strictly=True), metavar="S", help="give up after S simulated seconds"
    )
    parser.add_argument("--learn", action="store_true", help="let the map learn from the trip")
    parser.add_argument(
        "--record", type=Path, metavar="RUN", help="record the trip, for `tolman replay` and `tolman explain`"
    )
    add_live(parser)
    add_simulation(parser)
    add_robot(parser)


def run(options: argparse.Namespace) -> int:
    """Drives and reports."""
    check_robot(options)
    check_input(options.map, "map")
    if options.config is not None:
        check_input(options.config, "file of settings")
    if options.record is not None:
        check_output(options.record, replace=True)
    from ...session.requests import GoRequest
    from ...session.simulation import go_to

    with progress_line() as line, watched(options.live) as watch:
        report = go_to(request_of(GoRequest, options), line.simulated, watch)
    values = report.to_json()
    if options.json:
        print_json(values)
    elif values["reached"]:
        error = values["position_error_m"]
        away = "" if error is None else f", {100 * error:.1f} cm from its true place"
        print(
            f"reached node {options.to} by {' - '.join(map(str, values['path']))}{away}; "
            f"{values['distance_m']:.2f} m in {values['sim_time_s']:.0f} s simulated"
        )
    else:
        print(f"did not reach node {options.to}: {values['reason']}")
    return 0 if values["reached"] else 1


COMMAND = Command("go", DESCRIPTION, add_arguments, run)
