"""`tolman map`: explores a world and saves the map of it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..command import Command
from ..live import add_live, watched
from ..options import (
    add_force,
    add_robot,
    add_simulation,
    check_robot,
    integer,
    number,
    one_of,
    picture,
    pose,
    request_of,
)
from ..output import check_input, check_output, print_json, progress_line

if TYPE_CHECKING:
    from ...session.mapping import MapReport

DESCRIPTION = """Explores a world that the robot does not know by following its walls, builds the hybrid map
and saves it as it goes. The mapping ends when the robot is back where it began and knows it.

WORLD is the name of a built-in world (see `tolman worlds`) or a file: a world's YAML, a ROS map's
YAML, a maze drawn in text (.txt) or a Webots world (.wbt). With --robot it is
what the map calls the place."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman map`."""
    parser.add_argument("world", metavar="WORLD", help="what to explore")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="the map to write")
    side = "right or left: the side on which the robot keeps the wall (default right)"
    parser.add_argument("--side", type=one_of("right", "left"), default="right", metavar="SIDE", help=side)
    parser.add_argument(
        "--global-only", action="store_true", help="build the graph alone, without a local map at each node"
    )
    parser.add_argument("--max-nodes", type=integer(1), metavar="N", help="end after N nodes")
    parser.add_argument(
        "--max-time", type=number(0, strictly=True), metavar="S", help="end after S simulated seconds"
    )
    parser.add_argument(
        "--strategy",
        type=one_of("rows", "columns", "alternate"),
        default="alternate",
        metavar="NAME",
        help="how a local map is explored: by rows, by columns, or both in turn (alternate, the default)",
    )
    parser.add_argument(
        "--start",
        type=pose,
        metavar="X,Y,HEADING",
        help="where to begin (m, m, degrees; heading counter-clockwise from the x axis)",
    )
    parser.add_argument(
        "--islands",
        action="store_true",
        help="once the loop is closed, look for obstacles that stand free, and map them too",
    )
    parser.add_argument("--resume", action="store_true", help="go on from the last node saved in FILE")
    add_force(parser)
    parser.add_argument(
        "--figure", type=picture, metavar="PNG", help="also draw the map (.png, .svg or .pdf)"
    )
    parser.add_argument(
        "--record", type=Path, metavar="RUN", help="record the run, for `tolman replay` and `tolman explain`"
    )
    add_live(parser)
    add_simulation(parser)
    add_robot(parser)


def check(options: argparse.Namespace) -> None:
    """Checks the files that the options name before anything is simulated. Raises: UsageError."""
    check_robot(options)
    if options.resume:
        check_input(options.output, "map to resume")
    check_output(
        options.output,
        replace=options.force or options.resume,
        hint="--force replaces it, --resume goes on with it",
    )
    if options.figure is not None:
        check_output(options.figure, replace=True)
    if options.record is not None:
        check_output(options.record, replace=options.force)
    if options.config is not None:
        check_input(options.config, "file of settings")


def run(options: argparse.Namespace) -> int:
    """Maps, draws and reports."""
    check(options)
    from ...session.requests import MapRequest
    from ...session.simulation import map_world

    with progress_line() as line, watched(options.live) as watch:
        try:
            report = map_world(request_of(MapRequest, options), line.simulated, watch)
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(_saved(options.output))
            raise
        if options.figure is not None:
            from ...drawing.map_picture import plot_map

            plot_map(options.output, options.figure, None if options.robot else options.world, options.scale)
    return tell(report, options)


def _saved(path: Path) -> str:
    """What an interrupted mapping leaves, in words."""
    from ....maps import HybridMap, MapError

    try:
        nodes = len(HybridMap.load(path).nodes())
    except MapError:
        return f"{path}: nothing is saved yet"
    return f"{path} has {nodes} node{'' if nodes == 1 else 's'}; --resume goes on"


def tell(report: MapReport, options: argparse.Namespace) -> int:
    """Prints what the mapping gave; returns the exit status."""
    values = report.to_json()
    if options.json:
        print_json(values)
    else:
        closed = {True: "loop closed", False: "loop not closed"}[bool(values["loop_closed"])]
        print(
            f"{options.output}: {values['nodes']} nodes, {values['arcs']} arcs, "
            f"{values['local_maps']} local maps; {closed} ({values['reason']})"
        )
        if options.robot is None:
            print(
                f"{values['sim_time_s']:.0f} s simulated in {values['wall_time_s']:.1f} s; "
                f"ticks touching a wall: {values['collisions']}"
            )
        else:
            print(f"driven by {options.robot} in {values['wall_time_s']:.0f} s")
        if options.islands:
            print(f"{values['islands']} islands found by {values['forays']} forays: {values['scouted']}")
        if options.figure is not None:
            print(f"{options.figure}: drawn")
    return 0 if values["reason"] in ("loop closed", "max nodes", "max time") else 1


COMMAND = Command("map", DESCRIPTION, add_arguments, run)
