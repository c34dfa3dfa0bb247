"""`tolman calibrate`: measures the infrared sensors and the wheels of one robot."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...command import Command
from ...options import add_json, one_of
from ...output import ProgressLine, check_output, print_json, stdout_to_stderr

DESCRIPTION = """Measures a robot behind a link and keeps what it finds in FILE, for --calibration of other
commands. What FILE has of the other measurement stays.

  infrared   the sensors' baselines. Put the robot where nothing is within 10 cm; it rests for 2 s.
  wheels     the track, and what each sensor reads of the same wall. Put the robot 1 to 3 cm from one straight
             wall, and nothing else within 10 cm; it turns on the spot, six times, for about 90 s.

Measure infrared first. See docs/robots.md."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman calibrate`."""
    parser.add_argument("what", type=one_of("infrared", "wheels"), metavar="WHAT", help="infrared or wheels")
    parser.add_argument(
        "--robot",
        required=True,
        metavar="ADDRESS",
        help="the robot, tcp://HOST:PORT (a real one's port is 1000)",
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help="the file to write (YAML)"
    )
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Measures, and writes the file."""
    check_output(options.output, replace=True)
    from .....world.link.calibrating import measure_by_wall, measure_offsets
    from .....world.link.calibration import Calibration, load_calibration
    from .....world.link.opening import connect

    before = load_calibration(options.output) if options.output.exists() else Calibration()
    line = ProgressLine()
    with stdout_to_stderr(), connect(options.robot, "calibration", 0) as world:
        if options.what == "infrared":
            found = measure_offsets(world, before)
        else:
            found = measure_by_wall(world, before, lambda share: line.show(f"{share:4.0%} of six turns"))
        line.close()
    found.save(options.output, force=True)
    if options.json:
        print_json({"offsets": found.offsets, "gains": found.gains, "track": found.track})
    elif options.what == "infrared":
        print(f"{options.output}: offsets {', '.join(f'{each:.1f}' for each in found.offsets)} counts")
    else:
        print(f"{options.output}: track {found.track:.4f} of the published one; gains", end=" ")
        print(", ".join(f"{each:.2f}" for each in found.gains))
    return 0


COMMAND = Command("calibrate", DESCRIPTION, add_arguments, run)
