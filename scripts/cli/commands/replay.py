"""`tolman replay` and `tolman explain`: re-run a recorded session, and read it as a timeline."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path

from ....agent.recording.explain import CUT_OFF, timeline
from ....agent.recording.reader import read_recording
from ..command import Command
from ..options import add_json
from ..output import print_json, stdout_to_stderr


def _add_recording(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", type=Path, metavar="RUN", help="a recording that --record has written")
    add_json(parser)


def _add_replay(parser: argparse.ArgumentParser) -> None:
    _add_recording(parser)
    parser.add_argument(
        "--trust",
        action="store_true",
        help="run its mission and plugins too where they are not here as recorded",
    )


def _replay(options: argparse.Namespace) -> int:
    from ...session.replay import replay  # here: it loads maps and sessions, which `explain` does not need

    with stdout_to_stderr():
        report = replay(
            options.recording, options.trust, lambda text: print(f"replay runs {text}", file=sys.stderr)
        )
    if options.json:
        values = asdict(report) | {"identical": report.identical}
        print_json(values)
    elif report.identical:
        print(f"identical: {report.ticks} ticks{'' if report.complete else '; ' + CUT_OFF}")
    elif report.difference is not None:
        print(f"first difference at {report.difference.text()}")
    else:
        print(f"the replay ended after {report.ticks} of {report.recorded} ticks")
    return 0 if report.identical else 1


def _add_explain(parser: argparse.ArgumentParser) -> None:
    _add_recording(parser)
    parser.add_argument("--control", action="store_true", help="only who drove and why")


def _explain(options: argparse.Namespace) -> int:
    lines = list(timeline(read_recording(options.recording), changes_only=options.control))
    if options.json:
        print_json({"timeline": lines})
    else:
        print("\n".join(lines))
    return 0


COMMAND = Command(
    "replay",
    "Runs the agent again on the percepts and images of a recording and compares proposals, commands and\n"
    "events to the bit. Status 0: identical; 1: not, and the first difference is printed. Code runs only\n"
    "where it is on this machine as it was recorded, or with --trust.",
    _add_replay,
    _replay,
)
EXPLAIN = Command(
    "explain",
    "Prints what happened in a recorded session: every change of control with who wanted what, who won and\n"
    "why; every fault, step and event; and how long each behavior drove.",
    _add_explain,
    _explain,
)
