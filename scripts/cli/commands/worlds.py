"""`tolman worlds`: lists the built-in worlds."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from ..command import Command
from ..options import add_json
from ..output import print_json

if TYPE_CHECKING:
    from ....world.spec import WorldSpec


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman worlds`."""
    add_json(parser)


def run(options: argparse.Namespace) -> int:
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
    "list the built-in worlds",
    "Lists the built-in worlds. A world's YAML file, or a ROS map's, can be given wherever a world is named.",
    add_arguments,
    run,
)
