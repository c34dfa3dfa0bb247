"""`tolman worlds`: lists the built-in worlds."""

from __future__ import annotations

import argparse

from .cli_command import Command
from .cli_options import add_json
from .cli_output import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman worlds`."""
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Prints each world's name and what it is."""
    from ..world import built_in_worlds

    worlds = built_in_worlds()
    if options.json:
        print_json({"worlds": list(worlds)})
    else:
        for name in worlds:
            print(name)
    return 0


COMMAND = Command(
    "worlds",
    "list the built-in worlds",
    "Lists the built-in worlds. A world's YAML file, or a ROS map's, can be given wherever a world is named.",
    add_arguments,
    run,
)
