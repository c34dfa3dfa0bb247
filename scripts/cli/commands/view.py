"""`tolman view`: the page of a run or a map, opened in a browser."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import webbrowser

from ..command import Command
from ..options import integer
from .report import add_subject, page_of

DESCRIPTION = """Serves the page of a recording or a map to this machine alone, read only, and opens it in a
browser if there is one. Ends with Ctrl-C. For a file to keep or to send see `tolman report`."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_subject(parser)
    parser.add_argument("--port", type=integer(0), default=0, metavar="PORT", help="default: any free one")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")


def _run(options: argparse.Namespace) -> int:
    page = page_of(options)
    from ...report.server import PageServer

    try:
        with PageServer(page, options.port) as server:
            print(f"{options.subject} at {server.address} (Ctrl-C ends it)", flush=True)
            if not options.no_browser and _has_screen():
                webbrowser.open(server.address)
            threading.Event().wait()
    except KeyboardInterrupt:
        print("closed", file=sys.stderr)
    return 0


def _has_screen() -> bool:
    """Whether a browser would open in a window of its own: one in the terminal would take its place."""
    return sys.platform in ("darwin", "win32") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )


COMMAND = Command("view", DESCRIPTION, _add_arguments, _run)
