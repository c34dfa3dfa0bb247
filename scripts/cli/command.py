"""What a command consists of; its line in `tolman --help` stands in `program.COMMANDS`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

ANY_PORT = 0
"""Of `--live` without a number: any that is free."""


@dataclass(frozen=True, slots=True)
class Command:
    """One command: `description` stands above its options.

    add_arguments: adds the options to the command's parser. run: does the work, returns the exit status.
    """

    name: str
    description: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
