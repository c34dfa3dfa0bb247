"""`tolman export`: writes a map in a format that other programs read."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..command import Command
from ..options import add_force, one_of
from ..output import check_input, check_output

FORMATS = ("graphml", "json", "geojson", "ros")
DESCRIPTION = """Writes a map in a format that other programs read:

  graphml   the graph, for networkx, Gephi, yEd
  json      everything but the truth; a schema comes with it
  geojson   a route graph as the navigation stack of ROS 2 reads it
  ros       an occupancy grid drawn from the metric SOMs' free space: a YAML and a PGM beside it"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman export`."""
    parser.add_argument("map", type=Path, metavar="FILE", help="the map")
    parser.add_argument(
        "--format", type=one_of(*FORMATS), required=True, metavar="FORMAT", help=", ".join(FORMATS)
    )
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="file to write")
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Exports and says what was written."""
    check_input(options.map, "map")
    check_output(options.output, replace=options.force)
    from ....maps import HybridMap
    from ....maps.formats.exporting import export

    hybrid = HybridMap.load(options.map)
    for path in export(hybrid, options.format, options.output, force=options.force):
        print(f"{path}: written")
    return 0


COMMAND = Command("export", DESCRIPTION, add_arguments, run)
