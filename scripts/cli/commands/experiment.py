"""`tolman experiment`: measures what the thesis's chapter 4 measured, beside its figures, and more."""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ....files.reading import read_text
from ....files.writing import write_text
from ...errors import UsageError
from ...experiments.campaign.kinds import ENVIRONMENTS, FIRST_SEED
from ...plain import plain
from ..command import Command
from ..options import integer, number
from ..output import ProgressLine, check_input, check_output, progress_line

if TYPE_CHECKING:
    from ...experiments.campaign.campaign import Progress
    from ...experiments.campaign.running import Running
    from ...experiments.page import Page

DESCRIPTION = """Runs experiments of chapter 4 of the thesis in both profiles and prints their figures beside
the published ones. NAME is table-N for N = 4.2, 4.3, 4.5, 4.6, 4.10, 4.12, 4.14, 4.15, 4.16, 4.18, `all`
(these) or `smoke` (these, but one run in one environment). Beyond the thesis, profile `default` alone:
`variants` (rooms turned, mirrored, scaled, imported; more noise), `ablation` (each remedy off in turn),
`unseen` (rooms and mazes drawn from seeds), `shapes` (rooms with slanted or round walls or narrow passages),
`beyond` (unknown starts, changed worlds, obstacles that stand free).

Finished runs are kept in the work folder, with their maps; the same command goes on where it was interrupted,
and --finished-only reports what there is. Results do not depend on --jobs. Seeds below 4000 were used for
tuning, so the first one is 4000."""


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
        "--thesis-runs", type=integer(1), metavar="N", help="--runs of profile thesis, if others"
    )
    parser.add_argument(
        "--thesis-global-runs",
        type=integer(1),
        metavar="N",
        help="--global-runs of profile thesis, if others",
    )
    parser.add_argument(
        "--import",
        dest="imported",
        action="append",
        default=[],
        metavar="FILE[:SCALE]",
        help="a world file for `variants`, its lengths times SCALE; can be given again",
    )
    parser.add_argument("--max-hours", type=number(0), metavar="H", help="begin no run after so many hours")
    parser.add_argument("--finished-only", action="store_true", help="run nothing: report what has finished")
    parser.add_argument(
        "--first-seed",
        type=integer(0),
        default=FIRST_SEED,
        metavar="N",
        help="seed of the first run (default 4000)",
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
    parser.add_argument(
        "--notes", type=Path, metavar="FILE", help="Markdown to put into the report, as reasons for misses"
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="also write all figures as JSON")


def _environments(text: str) -> tuple[str, ...]:
    names = text.split(",")
    if not set(names) <= set(ENVIRONMENTS):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of {', '.join(ENVIRONMENTS)}")
    return tuple(name for name in ENVIRONMENTS if name in names)


def run(options: argparse.Namespace) -> int:
    """Runs what is missing, then reports."""
    for path in (options.report, options.json):
        if path is not None:
            check_output(path, replace=True)
    if options.notes is not None:
        check_input(options.notes, "Markdown file")
    if options.work.exists() and not options.work.is_dir():
        raise UsageError(f"{options.work} is a file; --work names a folder")
    page = _page(options)
    if page.studies and options.profile == "thesis":
        raise UsageError("studies are of profile default; leave out --profile thesis, or name tables alone")
    with progress_line() as line, _stopped_like_an_interrupt():
        page.run(_running(options, line))
        pictures = []
        if options.figures is not None:
            base = options.report.parent if options.report is not None else Path()
            pictures = _draw(page, options.figures, base)
    if options.json is not None:
        values = plain(page.values())
        write_text(options.json, json.dumps(values, indent=2, allow_nan=False) + "\n", replace=True)
    text = page.text(pictures)
    if options.report is not None:
        write_text(options.report, text, replace=True)
        print(f"{options.report}: written")
    else:
        print(text, end="")
    return 1 if page.errors else 0


def _page(options: argparse.Namespace) -> Page:
    """The page that the options ask for. Raises: CampaignError, WorldError."""
    from ...experiments.campaign.plan import plan_for
    from ...experiments.page import STUDIES, Page
    from ...experiments.studies.study import Asked
    from ...experiments.worlds.named import import_world

    studies = [STUDIES[name] for name in dict.fromkeys(options.names) if name in STUDIES]
    tables = [name for name in options.names if name not in STUDIES]
    plan = plan_for(tables, options.runs, options.global_runs, options.first_seed, tuple(STUDIES))
    plan = replace(
        plan,
        thesis_runs=options.thesis_runs,
        thesis_global_runs=options.thesis_global_runs,
        profiles=plan.profiles if options.profile == "both" else (options.profile,),
        environments=options.environments or plan.environments,
    )
    asked = Asked(
        options.runs,
        options.first_seed,
        options.environments or ENVIRONMENTS,
        tuple(import_world(source, options.work) for source in options.imported),
    )
    notes = "" if options.notes is None else read_text(options.notes, 1_000_000).strip()
    return Page(plan, studies, asked, options.work, notes)


def _draw(page: Page, folder: Path, base: Path) -> list[tuple[str, str]]:
    """Draws the figures of the tables; (title, path from `base`) of each."""
    if not page.plan.tables:
        return []
    from ...experiments.report.figures import draw_figures

    return draw_figures(page.plan, page.outcome, page.folder, folder, base)


@contextlib.contextmanager
def _stopped_like_an_interrupt() -> Iterator[None]:
    """Ends the worker processes too when this one is told to terminate."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _running(options: argparse.Namespace, line: ProgressLine) -> Running:
    """How the options want runs to be run."""
    from ...experiments.campaign.running import Running

    until = None
    if options.finished_only:
        until = time.monotonic()
    elif options.max_hours is not None:
        until = time.monotonic() + 3600.0 * options.max_hours

    def show(what: str, progress: Progress) -> None:
        left = "" if progress.seconds_left is None else f", about {progress.seconds_left / 60:.0f} min left"
        line.show(f"{what}: {progress.done} of {progress.total} runs{left}")

    return Running(options.jobs, options.dask, until, show)


COMMAND = Command("experiment", DESCRIPTION, add_arguments, run)
