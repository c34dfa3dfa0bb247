"""`tolman experiment`: measures what the thesis's chapter 4 measured, beside its published figures."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .cli_command import Command
from .cli_errors import UsageError
from .cli_options import integer
from .cli_output import ProgressLine, check_output, plain, stdout_to_stderr

DESCRIPTION = """Runs experiments of chapter 4 of the thesis in both profiles and prints their figures beside
the published ones. NAME is table-N for N = 4.2, 4.3, 4.5, 4.6, 4.10, 4.12, 4.14, 4.15, 4.16, 4.18, `all` or
`smoke` (everything, but one run in one environment).

Finished runs are kept in the work folder, with their maps; the same command goes on where it was interrupted.
Results do not depend on --jobs. Seeds below 1000 are meant for tuning, so the first one is 1000."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman experiment`."""
    parser.add_argument("names", metavar="NAME", nargs="+", help="which experiments")
    parser.add_argument(
        "--runs", type=integer(1), metavar="N", help="runs an environment and profile (default 20; 50 global)"
    )
    parser.add_argument(
        "--global-runs", type=integer(1), metavar="N", help="the same where no local maps are built"
    )
    parser.add_argument(
        "--first-seed",
        type=integer(0),
        default=1000,
        metavar="N",
        help="seed of the first run (default 1000)",
    )
    parser.add_argument("--jobs", type=integer(1), default=1, metavar="N", help="processes (default 1)")
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="run on a Dask cluster instead (needs tolman[dask])"
    )
    parser.add_argument(
        "--profile",
        choices=("both", "default", "thesis"),
        default="both",
        help="which profiles (default both)",
    )
    parser.add_argument(
        "--environments",
        type=_environments,
        metavar="LIST",
        help="which environments, as in env1,env3 (default all)",
    )
    parser.add_argument(
        "--work",
        type=Path,
        default=Path("tolman-experiment"),
        metavar="DIR",
        help="folder of finished runs and maps (default tolman-experiment)",
    )
    parser.add_argument(
        "--report", type=Path, metavar="FILE", help="write the report there instead of stdout"
    )
    parser.add_argument("--figures", type=Path, metavar="DIR", help="also draw the figures into this folder")
    parser.add_argument("--json", type=Path, metavar="OUT", help="also write all figures as JSON")


def _environments(text: str) -> tuple[str, ...]:
    known = ("env1", "env2", "env3")
    names = text.split(",")
    if not set(names) <= set(known):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of {', '.join(known)}")
    return tuple(name for name in known if name in names)


def run(options: argparse.Namespace) -> int:
    """Runs what is missing, then reports."""
    for path in (options.report, options.json):
        if path is not None:
            check_output(path, replace=True)
    if options.work.exists() and not options.work.is_dir():
        raise UsageError(f"{options.work} is a file; --work names a folder")
    from dataclasses import replace

    from .experiment_plan import plan_for, run_plan
    from .experiment_report import report_text, report_values
    from .experiment_version import code_version

    plan = plan_for(options.names, options.runs, options.global_runs, options.first_seed)
    if options.profile != "both":
        plan = replace(plan, profiles=(options.profile,))
    if options.environments is not None:
        plan = replace(plan, environments=options.environments)
    version = code_version()
    line = ProgressLine()
    with stdout_to_stderr():
        outcome = run_plan(
            plan,
            options.work,
            processes=options.jobs,
            dask=options.dask,
            progress=lambda what, done, total: line.show(f"{what}: {done} of {total} runs"),
        )
        line.close()
        pictures: list[tuple[str, str]] = []
        if options.figures is not None:
            from .experiment_figures import draw_figures

            base = options.report.parent if options.report is not None else Path()
            pictures = draw_figures(plan, outcome, options.work, options.figures, base)
    text = report_text(plan, outcome, version, pictures)
    if options.json is not None:
        values = plain(report_values(plan, outcome, version))
        options.json.write_text(json.dumps(values, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    if options.report is not None:
        options.report.write_text(text, encoding="utf-8")
        print(f"{options.report}: written")
    else:
        print(text, end="")
    return 0


COMMAND = Command("experiment", "measure it against the published figures", DESCRIPTION, add_arguments, run)
