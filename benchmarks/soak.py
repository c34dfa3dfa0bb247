"""Drives a million control steps and watches the memory: `python -m benchmarks.soak [STEPS]`.

The robot wanders through a world, against walls too, under noise, and takes a camera image now and then. The
memory of the process is read every tenth of the way. Exit 1 if it grew after the first tenth.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from tolman.agent import Agent
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.behaviors.wander import Wander
from tolman.world import open_world

ALLOWED = 5.0
"""MB that the process may grow by after the first tenth: caches of squares of the floor fill up slowly."""
LOOK_EVERY = 500
"""Steps between camera images; fewer in a short run, so that its first tenth has some too."""


def memory() -> float:
    """Resident memory of this process now (MB)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def soak(steps: int, world: str, model: str) -> list[float]:
    """MB after each tenth of the steps."""
    arena = open_world(world, model=model, noise="thesis", seed=1)
    agent = Agent(arena.robots[0], [ObstacleAvoidance(), Wander()])
    for name in agent.behaviors:
        agent.start(name)
    tenth = max(1, steps // 10)
    look_every = min(LOOK_EVERY, max(1, tenth // 2))
    readings, began = [], time.perf_counter()
    for step in range(1, steps + 1):
        agent.tick()
        arena.step()
        if step % look_every == 0:
            arena.robots[0].look()
        if step % tenth == 0:
            readings.append(memory())
            took = time.perf_counter() - began
            print(
                f"{step} steps, {took:.0f} s, {readings[-1]:.1f} MB, {arena.collisions()} in contact",
                flush=True,
            )
    return readings


def main() -> int:
    """Soaks and says whether memory was flat."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("steps", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--world", default="env2")
    parser.add_argument("--model", default="wheels")
    options = parser.parse_args()
    readings = soak(options.steps, options.world, options.model)
    growth = max(readings[1:]) - readings[0]
    print(f"{options.steps} control steps of {options.model} in {options.world}: grew by {growth:.1f} MB")
    return 1 if growth > ALLOWED else 0


if __name__ == "__main__":
    sys.exit(main())
