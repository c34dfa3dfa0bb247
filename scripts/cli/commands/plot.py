"""`tolman plot`: draws a map file."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..command import Command
from ..options import add_scale, picture
from ..output import check_input, check_output

DESCRIPTION = """Draws a map: nodes, arcs and metric SOMs, and, where the file tells (maps made in simulation
do), the walls and the path that was truly driven. An existing picture is drawn over."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman plot`."""
    parser.add_argument("map", type=Path, metavar="FILE", help="the map")
    parser.add_argument(
        "-o",
        "--output",
        type=picture,
        required=True,
        metavar="PNG",
        help="picture to draw (.png, .svg, .pdf)",
    )
    parser.add_argument(
        "--world", metavar="WORLD", help="draw the walls of this world, for a map made in a world file"
    )
    add_scale(parser)


def run(options: argparse.Namespace) -> int:
    """Draws the map."""
    check_input(options.map, "map")
    check_output(options.output, replace=True)
    from ...drawing.map_picture import plot_map

    plot_map(options.map, options.output, options.world, options.scale)
    print(f"{options.output}: drawn")
    return 0


COMMAND = Command("plot", DESCRIPTION, add_arguments, run)
