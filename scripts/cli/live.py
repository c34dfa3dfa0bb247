"""`--live`: a page of the run while it happens."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from .command import ANY_PORT
from .options import integer

if TYPE_CHECKING:
    from ..session.simulation import Watch


def add_live(parser: argparse.ArgumentParser) -> None:
    """Adds --live. The program gives it `ANY_PORT` where no port follows."""
    parser.add_argument(
        "--live",
        type=integer(ANY_PORT),
        metavar="PORT",
        help="serve a page of the run while it happens, to this machine alone (default PORT: any free)",
    )


@contextlib.contextmanager
def watched(port: int | None) -> Iterator[Watch | None]:
    """What looks on for a live page while inside; None, and nothing is loaded, without a port."""
    if port is None:
        yield None
        return
    from ..report.live import live_page

    def tell(address: str) -> None:
        print(f"live at {address}", file=sys.stderr, flush=True)

    with live_page(port, tell) as watch:
        yield watch
