"""`tolman report`: a run or a map as one page that opens offline."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..command import Command
from ..options import add_force
from ..output import check_input, check_output

DESCRIPTION = """Writes one self-contained HTML file that opens offline: the world and the robot in it, what
it believed, who drove and why, the map as it grew, and a slider over the run. FILE is a recording that
--record has written, or a map."""


def add_subject(parser: argparse.ArgumentParser) -> None:
    """Adds what says what is shown."""
    parser.add_argument("subject", type=Path, metavar="FILE", help="a recording (.mcap) or a map")
    parser.add_argument(
        "--map", type=Path, metavar="FILE", help="the map that a recorded run made, if it is not found"
    )
    parser.add_argument(
        "--world", metavar="WORLD", help="draw the walls of this world instead of the recorded one"
    )


def page_of(options: argparse.Namespace) -> str:
    """The page that the options ask for; says on stderr where a map was found. Raises: as `read_subject`."""
    check_input(options.subject, "recording or map")
    if options.map is not None:
        check_input(options.map, "map")
    from ...report.page import make_page
    from ...report.subject import read_subject

    subject = read_subject(options.subject, options.map, options.world)
    for remark in subject.remarks:
        print(remark, file=sys.stderr)
    return make_page(subject.content)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_subject(parser)
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="PAGE", help="the HTML file to write"
    )
    add_force(parser)


def _run(options: argparse.Namespace) -> int:
    from ....files.writing import write_text

    check_output(options.output, replace=options.force)
    page = page_of(options)
    write_text(options.output, page, replace=options.force)
    print(f"{options.output}: {len(page) / 1e6:.1f} MB; open it in a browser")
    return 0


COMMAND = Command("report", DESCRIPTION, _add_arguments, _run)
