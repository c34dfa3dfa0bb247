"""The command `tolman`: parses a command line, runs the command and turns errors into one line each.

Exit status: 0 done, 1 the run failed, 2 bad usage or bad input, 130 interrupted (143 by SIGTERM).
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
import threading
from collections.abc import Sequence
from importlib.metadata import version
from itertools import zip_longest
from typing import NoReturn

from ...files.interrupts import raised
from ..errors import UsageError, describe, did_you_mean, status_of
from .command import ANY_PORT, Command
from .streams import escaped_streams, flushed, open_standard_streams

COMMANDS = {
    "worlds": ("worlds:COMMAND", "list the built-in worlds, draw others"),
    "map": ("map:COMMAND", "explore a world and save the map of it"),
    "go": ("go:COMMAND", "find the way to a node of a saved map"),
    "info": ("info:COMMAND", "say what a map holds"),
    "plot": ("plot:COMMAND", "draw a map to a PNG, SVG or PDF"),
    "validate": ("validate:COMMAND", "say what is wrong with a map file, and recover it"),
    "export": ("export:COMMAND", "write a map for other programs"),
    "diff": ("diff:COMMAND", "compare two maps of the same world"),
    "merge": ("diff:MERGE", "join two maps of the same world"),
    "run": ("run:COMMAND", "run a mission, or show what it would do"),
    "replay": ("replay:COMMAND", "re-run a recorded session and report the first difference"),
    "explain": ("replay:EXPLAIN", "read a recorded session as a timeline: who drove, and why"),
    "report": ("report:COMMAND", "a run or a map as one page to look at, offline"),
    "view": ("view:COMMAND", "open that page in a browser"),
    "plugins": ("plugins:COMMAND", "list, check, write and draw behaviors"),
    "experiment": ("experiment:COMMAND", "measure it against the published figures"),
    "serve": ("robots.serve:COMMAND", "let programs for a real e-puck2 drive a simulated one"),
    "calibrate": ("robots.calibrate:COMMAND", "measure infrared sensors and wheels of one robot"),
}
"""Command -> (module of `commands` with the `Command` in it, its line in --help), so that help loads none."""

EPILOG = """examples:
  tolman worlds                                    what there is to explore
  tolman map env1 -o m.tolman --figure m.png       explore env1, save the map and a picture of it
  tolman info m.tolman                             what the map knows
  tolman go m.tolman --to 5                        find the way to node 5, from where the mapping ended

`tolman COMMAND --help` explains a command's options."""


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose errors are one line, and which suggests the option that was meant."""

    def error(self, message: str) -> NoReturn:
        """Prints the message as one line and exits with status 2."""
        line = " ".join(message.split())
        self.exit(2, f"tolman: error: {line} (see `{self.prog} --help`)\n")

    def options(self) -> list[str]:
        """The long options this parser knows."""
        return sorted(set(re.findall(r"--[a-z][a-z-]*", self.format_help())))


def build_parser(command: Command) -> Parser:
    """The parser of one command."""
    parser = Parser(
        prog=f"tolman {command.name}",
        description=command.description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    command.add_arguments(parser)
    return parser


def build_main_parser() -> Parser:
    """The parser of what stands before the command; it also prints the list of commands."""
    commands = "\n".join(f"  {name:<12}{summary}" for name, (_, summary) in COMMANDS.items())
    parser = Parser(
        prog="tolman",
        usage="tolman COMMAND [OPTIONS]",
        description="A robot explores an unknown walled world, builds a hybrid map of it\n"
        f"and finds its way with it later.\n\ncommands:\n{commands}",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"tolman {version('tolman')}")
    return parser


def load(name: str) -> Command:
    """Imports a command; only then is anything loaded that it needs."""
    module, _, attribute = COMMANDS[name][0].partition(":")
    command = getattr(importlib.import_module(f".commands.{module}", __package__), attribute)
    assert isinstance(command, Command)
    return command


def join_values(arguments: Sequence[str]) -> list[str]:
    """Joins options and values that argparse would misread.

    A list of numbers may start with a minus. `--live` may stand without a port, also before other arguments.
    """
    joined: list[str] = []
    for argument, after in zip_longest(arguments, arguments[1:], fillvalue=""):
        if argument == "--live" and not after.isdecimal():
            joined.append(f"--live={ANY_PORT}")
        elif re.match(r"-[\d.]+,", argument) and joined and re.fullmatch(r"--[a-z-]+", joined[-1]):
            joined[-1] += "=" + argument
        else:
            joined.append(argument)
    return joined


def parse(arguments: Sequence[str]) -> tuple[Command, argparse.Namespace]:
    """The command and its parsed options. Exits with status 0 after --help, 2 on bad usage."""
    if not arguments or arguments[0].startswith("-"):
        main_parser = build_main_parser()
        main_parser.parse_args(arguments)
        main_parser.error("name a command: " + ", ".join(COMMANDS))
    name, *rest = arguments
    known = COMMANDS
    if name not in known:
        raise UsageError(
            f"unknown command {name!r}{did_you_mean(name, known)} (commands: {', '.join(known)})"
        )
    command = load(name)
    parser = build_parser(command)
    namespace, unknown = parser.parse_known_args(join_values(rest))
    if unknown:
        parser.error(f"unexpected argument {unknown[0]!r}{did_you_mean(unknown[0], parser.options())}")
    return command, namespace


def execute(arguments: Sequence[str]) -> int:
    """Runs a command line and returns its exit status."""
    with escaped_streams(), raised():
        return _execute(arguments)


def _execute(arguments: Sequence[str]) -> int:
    try:
        command, namespace = parse(arguments)
        status = command.run(namespace)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        flushed(sys.stdout, 1)
        return 141
    except KeyboardInterrupt as interrupt:
        saved = "; ".join(getattr(interrupt, "__notes__", ())) or "what was reported as saved is saved"
        print(f"tolman: interrupted; {saved}", file=sys.stderr)
        return 128 + getattr(interrupt, "number", 2)
    except Exception as error:
        flushed(sys.stdout, 1)
        status_or_none = status_of(error)
        if status_or_none is None:
            raise
        print(f"tolman: error: {describe(error)}", file=sys.stderr)
        return status_or_none


def main() -> int:
    """Entry point of the command."""
    # Before numpy is loaded: with more threads, sums and so the bytes of a map would depend on the machine.
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    open_standard_streams()
    with escaped_streams(), raised():  # to the end: threads of plugins may still print
        status = _execute(sys.argv[1:])
        if not flushed(sys.stdout, 1) and status == 0:
            status = 1
        flushed(sys.stderr, 2)
        if _plugins_were_here():
            os._exit(status)
    return status


def _plugins_were_here() -> bool:
    """Whether code from plugin folders ran, or threads go on: neither may hold the end up or change it."""
    threads = [thread for thread in threading.enumerate() if not thread.daemon]
    return len(threads) > 1 or any(name.startswith("tolman_plugin_") for name in sys.modules)
