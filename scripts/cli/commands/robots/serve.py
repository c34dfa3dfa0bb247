"""`tolman serve`: makes a simulated e-puck2 a server of the real one's Wi-Fi protocol."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from ....errors import UsageError
from ...command import Command
from ...options import LINKS, NOISES, add_json, add_scale, integer, number, one_of, pose
from ...output import print_json, stdout_to_stderr

if TYPE_CHECKING:
    from .....world.link.server import Server

DESCRIPTION = """Simulates a world with an e-puck2 that answers by its Wi-Fi protocol, so that programs for
the real robot drive it unchanged. Serves one client after the other until it is interrupted (Ctrl-C).

The robot streams in real time; with --fast each command lets 32 ms pass and is answered once, so that a
program that waits for answers goes as fast as it can. See docs/robots.md."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman serve`."""
    parser.add_argument("world", metavar="WORLD", help="the world: as for `tolman map`")
    parser.add_argument(
        "--port",
        type=integer(0, 65535),
        default=10000,
        metavar="N",
        help="where to listen (default 10000; 0 takes a free one; a real robot's is 1000)",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="HOST",
        help="address to listen at (default: this machine only)",
    )
    parser.add_argument("--fast", action="store_true", help="as fast as the client asks, not in real time")
    parser.add_argument(
        "--goes-on",
        action="store_true",
        help="wheels keep turning when a client is gone, as the real ones do",
    )
    parser.add_argument("--once", action="store_true", help="end when the first client is gone")
    parser.add_argument(
        "--max-time", type=number(0, strictly=True), metavar="S", help="end after S seconds by the clock"
    )
    parser.add_argument(
        "--link",
        type=one_of(*LINKS),
        default="ideal",
        metavar="NAME",
        help="delays: ideal, calm or published",
    )
    parser.add_argument(
        "--off-the-shelf",
        action="store_true",
        help="infrared sensors with gains and offsets of their own, which follow from --seed",
    )
    parser.add_argument(
        "--start", type=pose, metavar="X,Y,HEADING", help="where the robot stands (m, m, degrees)"
    )
    group = parser.add_argument_group("simulation")
    group.add_argument(
        "--seed", type=integer(0), default=0, metavar="N", help="for all randomness (default 0)"
    )
    group.add_argument(
        "--noise",
        type=one_of(*NOISES),
        default="thesis",
        metavar="PRESET",
        help="none, encoder or thesis (default)",
    )
    group.add_argument(
        "--robot-model",
        type=one_of("wheels", "planar"),
        default="wheels",
        metavar="MODEL",
        help="wheels (default) or planar",
    )
    add_scale(group)
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Serves, and says at its end what it did."""
    if options.fast and options.link != "ideal":
        raise UsageError("--fast and --link do not go together: delays need a clock")
    from .....world.factory import open_world
    from .....world.link.device import Device
    from .....world.link.model import find_timings
    from .....world.link.server import Server
    from .....world.link.units import E_PUCK2, IDEAL, drawn_specimen

    with stdout_to_stderr():
        world = open_world(
            options.world,
            seed=options.seed,
            noise=options.noise,
            start=options.start,
            model=options.robot_model,
            geometry=E_PUCK2,
            scale=options.scale,
        )
    with world:
        specimen = drawn_specimen(options.seed) if options.off_the_shelf else IDEAL
        server = Server(
            Device(world, specimen),
            options.host,
            options.port,
            fast=options.fast,
            stops=not options.goes_on,
            timings=find_timings(options.link),
            seed=options.seed,
        )
        _serve(server, options)
        values = {
            "world": world.spec.name,
            "clients": server.served,
            "commands": server.commands,
            "sim_time_s": world.time,
            "collisions": world.collisions(),
        }
    if options.json:
        print_json(values)
    else:
        print(
            f"clients: {values['clients']}, commands: {values['commands']}; "
            f"{values['sim_time_s']:.0f} s simulated, ticks touching a wall: {values['collisions']}"
        )
    return 0


def _serve(server: Server, options: argparse.Namespace) -> None:
    end = None if options.max_time is None else time.monotonic() + options.max_time

    def over() -> bool:
        gone = options.once and server.served > 0 and not server.connected
        return gone or (end is not None and time.monotonic() >= end)

    with stdout_to_stderr():
        shown = f"[{server.host}]" if ":" in server.host else server.host
        print(f"serving {options.world} at tcp://{shown}:{server.port}; Ctrl-C ends it", flush=True)
    try:
        server.serve(over)
    except KeyboardInterrupt:
        server.close()


COMMAND = Command("serve", DESCRIPTION, add_arguments, run)
