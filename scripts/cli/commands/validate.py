"""`tolman validate`: says what is wrong with a map file and what of it can be saved."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..command import Command
from ..options import add_force, add_json
from ..output import check_input, check_output, print_json

DESCRIPTION = """Checks everything in a map file, down to the bytes of each local map, and says what is wrong
with it and what of it can be saved. Exit status 0 if nothing is wrong, 1 if something is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman validate`."""
    parser.add_argument("map", type=Path, metavar="FILE", help="the map")
    parser.add_argument("--recover", type=Path, metavar="OUT", help="write what can be saved to this new map")
    add_force(parser)
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Prints the problems, one a line; recovers if asked to."""
    check_input(options.map, "map")
    if options.recover is not None:
        check_output(options.recover, replace=options.force)
    from ....maps.storage.validation import recover, validate

    if options.recover is None:
        found = validate(options.map)
    else:
        found = recover(options.map, options.recover, force=options.force)
    saved = f"{found.savable_nodes} nodes, {found.savable_arcs} arcs, {found.savable_local_maps} local maps"
    if options.json:
        print_json(
            {
                "valid": found.valid,
                "problems": list(found.problems),
                "savable_nodes": found.savable_nodes,
                "savable_arcs": found.savable_arcs,
                "savable_local_maps": found.savable_local_maps,
                "recovered": None if options.recover is None else str(options.recover),
            }
        )
    else:
        for problem in found.problems:
            print(problem)
        print(f"{options.map}: {'valid' if found.valid else 'not valid'}; can be saved: {saved}")
        if options.recover is not None:
            print(f"{options.recover}: written")
    return 0 if found.valid or options.recover is not None else 1


COMMAND = Command("validate", DESCRIPTION, add_arguments, run)
