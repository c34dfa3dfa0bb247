"""Measures one control tick without physics: six behaviors, all of them asked every tick.

Run with `python -m benchmarks.tick`. Prints the median and the 99th percentile in microseconds;
the target is a median of at most 60.
"""

from __future__ import annotations

import sys
import time
from enum import Enum

import numpy as np
from tolman.agent import Agent, Behavior, Context, Proposal
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.behaviors.wander import Wander
from tolman.plugins.testing import ScriptedRobot, percept
from tolman.world.robot import Percept, WheelCommand


class _Layer(Behavior):
    """A stand-in that weighs its sensors and always proposes."""

    class States(Enum):
        """Only one."""

        ON = "on"

    initial = States.ON

    def propose(self, percept: Percept, context: Context) -> Proposal | None:
        """Speeds by a weighted sum, as a reactive layer has them."""
        infrared = percept.infrared
        difference = 0.1 * (infrared[0] + infrared[1] - infrared[6] - infrared[7])
        return Proposal(WheelCommand(200.0 - difference, 200.0 + difference), 0.5, "layer")


def six_behaviors() -> list[Behavior]:
    """The two reactive built-in ones and four stand-ins, strongest first."""
    layers: list[Behavior] = [ObstacleAvoidance(), Wander()]
    for index in range(4):
        layers.append(type(f"Layer{index}", (_Layer,), {"name": f"layer-{index}", "priority": 10 * index})())
    return layers


def measure(ticks: int = 20_000) -> tuple[float, float]:
    """(median, 99th percentile) of a tick in seconds, on a robot that senses a wall on its right."""
    robot = ScriptedRobot([percept(right=0.022)])
    agent = Agent(robot, six_behaviors())
    for name in agent.behaviors:
        agent.start(name)
    durations = np.empty(ticks)
    for tick in range(ticks):
        start = time.perf_counter()
        agent.tick()
        durations[tick] = time.perf_counter() - start
    return float(np.median(durations)), float(np.percentile(durations, 99.0))


MOST = 60e-6
"""Seconds that the median tick may take."""


def main() -> int:
    """Prints what was measured. Status 1 beyond the target."""
    median, late = measure()
    print(f"tick without physics, six behaviors: median {median * 1e6:.1f} us, p99 {late * 1e6:.1f} us")
    return 0 if median <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
