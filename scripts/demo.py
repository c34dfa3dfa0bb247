"""The demo, `make demo`: explores env1, saves and draws the map, then finds its way with it later."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

TRIPS = 3


class DemoError(RuntimeError):
    """A step of the demo failed; the command has said why."""


def tolman(*arguments: str) -> dict[str, Any]:
    """Runs the command `tolman ... --json` in a new process; its progress goes to the terminal.

    Raises: DemoError if the command fails.
    """
    print(f"\n$ tolman {' '.join(arguments)}", flush=True)
    command = [sys.executable, "-m", "tolman.scripts.cli", *arguments, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1) or not done.stdout:
        raise DemoError(f"`tolman {arguments[0]}` ended with status {done.returncode}")
    report = json.loads(done.stdout)
    assert isinstance(report, dict)
    return report


def spread(nodes: Sequence[int], count: int) -> list[int]:
    """`count` of the nodes (all, if there are fewer), as far apart in the list as can be."""
    count = min(count, len(nodes))
    return [nodes[(2 * k + 1) * len(nodes) // (2 * count)] for k in range(count)]


def explore(folder: Path, seed: int) -> tuple[Path, list[int]]:
    """Maps env1 and draws the map. Returns the map's path and its nodes. Raises: DemoError."""
    path, picture = folder / "env1.tolman", folder / "env1.png"
    report = tolman(
        *("map", "env1", "-o", str(path), "--figure", str(picture)),
        *("--noise", "thesis", "--seed", str(seed), "--force"),
    )
    print(
        f"mapped {report['nodes']} nodes and {report['arcs']} arcs, {report['reason']}; "
        f"{report['sim_time_s']:.0f} simulated seconds in {report['wall_time_s']:.1f} s "
        f"({report['real_time_factor']:.0f} x real time), {report['collisions']} ticks touching a wall"
    )
    print(f"picture: {picture}")
    if not report["loop_closed"]:
        raise DemoError(f"the loop was not closed: {report['reason']}")
    return path, tolman("info", str(path))["node_ids"]


def visit(path: Path, nodes: Sequence[int], seed: int) -> list[bool]:
    """Goes to each of the nodes in turn, each trip in a process of its own. Returns which were reached."""
    reached = []
    start: tuple[str, ...] = ()
    for node in nodes:
        trip = tolman("go", str(path), "--to", str(node), *start, "--seed", str(seed))
        reached.append(bool(trip["reached"]))
        if trip["reached"]:
            print(
                f"reached node {node} by {'-'.join(map(str, trip['path']))}, {trip['distance_m']:.2f} m: "
                f"stopped {100 * trip['position_error_m']:.2f} cm from where the node truly is"
            )
            start = ("--from", str(node))
        else:
            print(f"did not reach node {node}: {trip['reason']}")
    return reached


def what_now(path: Path) -> list[str]:
    """What is there to be seen, and what to try with it."""
    command = "tolman" if shutil.which("tolman") else ".venv/bin/tolman"
    return [
        f"Look at {path.with_suffix('.png').resolve()}",
        "  walls are dark, nodes are discs, arcs green with the length the robot measured, the free space it",
        "  knows and the SOMs it made of it blue. Nobody told it anything of the room.",
        "Then try",
        f"  {command} go {path} --to 5 --lost      # dropped somewhere, it finds out where it is",
        f"  {command} map env2 -o env2.tolman --figure env2.png --global-only",
        "or write a behavior of your own: docs/tutorials/first-behavior.md",
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the demo; the exit status is 0 only if every node was reached."""
    parser = argparse.ArgumentParser(prog="make demo", description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("out/demo"), help="where map and picture go")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    try:
        path, nodes = explore(options.folder, options.seed)
        reached = visit(path, spread(nodes, TRIPS), options.seed)
    except DemoError as error:
        print(f"tolman: demo failed: {error}", file=sys.stderr)
        return 1
    print(f"\n{sum(reached)} of {len(reached)} nodes reached; {time.monotonic() - began:.0f} s in all")
    print("\n".join(what_now(path)))
    return 0 if all(reached) else 1


if __name__ == "__main__":
    sys.exit(main())
