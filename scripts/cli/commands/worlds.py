"""`tolman worlds`: lists the built-in worlds, and draws others from seeds."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import UsageError
from ..command import Command
from ..options import add_json, integer, one_of
from ..output import print_json

if TYPE_CHECKING:
    from ....world.spec import WorldSpec


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman worlds`."""
    parser.add_argument(
        "action",
        nargs="?",
        default="list",
        type=one_of("list", "make"),
        metavar="ACTION",
        help="list (default), or make: draw a world from a seed",
    )
    parser.add_argument(
        "kind", nargs="?", metavar="KIND", help="what `make` draws; without it, lists the kinds"
    )
    parser.add_argument(
        "--seed", type=integer(0), default=0, metavar="N", help="which world of that kind (0)"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="the .yaml file that `make` writes")
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Does what the action says."""
    return _make(options) if options.action == "make" else _list(options)


def _make(options: argparse.Namespace) -> int:
    """Draws a world into a file, with its image beside it where the kind has one."""
    from ....files.writing import check_target, write_bytes
    from ....world.generators.catalog import KINDS, make_world

    if options.kind is None:
        for kind in KINDS.values():
            print(f"{kind.name:<10} {kind.description}")
        return 0
    path: Path | None = options.output
    if path is None or path.suffix not in (".yaml", ".yml"):
        raise UsageError("say where the world is to be written: -o FILE.yaml")
    drawn = make_world(options.kind, options.seed, path.stem)
    files = {path: drawn.text.encode(), **{path.with_suffix(end): data for end, data in drawn.beside.items()}}
    for each in files:
        check_target(each, replace=options.force)
    for each, data in files.items():
        write_bytes(each, data, replace=options.force)
    if options.json:
        print_json({"kind": options.kind, "seed": options.seed, "files": [str(each) for each in files]})
    else:
        print(f"{path}: {KINDS[options.kind].description}; try `tolman map {path} -o m.tolman --global-only`")
    return 0


def _list(options: argparse.Namespace) -> int:
    """Prints each world's name and what it is."""
    from ....world.arenas.catalog import built_in_world, built_in_worlds

    worlds = [built_in_world(name) for name in built_in_worlds()]
    if options.json:
        print_json({"worlds": [describe(world) for world in worlds]})
    else:
        width = max(len(world.name) for world in worlds)
        for world in worlds:
            print(f"{world.name:<{width}}  {world.description}")
    return 0


def describe(world: WorldSpec) -> dict[str, Any]:
    """A world as JSON values; poses in m, m, degrees."""
    starts = {
        start.name: [start.pose.x, start.pose.y, round(math.degrees(start.pose.heading), 6)]
        for start in world.starts
    }
    return {
        "name": world.name,
        "description": world.description,
        "shapes": len(world.shapes),
        "movable": len(world.movable),
        "robots": 1 + len(world.robots),
        "starts": starts,
        "digest": world.digest,
    }


COMMAND = Command(
    "worlds",
    "Lists the built-in worlds. A world's YAML file, or a ROS map's, can be given wherever a world is named. "
    "`tolman worlds make KIND --seed N -o FILE` draws one: scanned plans, offices, halls, mazes, clutter.",
    add_arguments,
    run,
)
