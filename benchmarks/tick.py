"""Measures one control tick without physics, and what testing a behavior alone costs.

Run with `python -m benchmarks.tick`. The tick has six behaviors, all of them asked. A behavior alone is made,
started and asked for fifty ticks, without an agent. The exit status is 1 if a figure misses its target, or
if a simulator was loaded.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from enum import Enum
from functools import partial

import numpy as np
from tolman.agent import Agent, Behavior, Context, Proposal
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.behaviors.wander import Wander
from tolman.plugins.check import percepts
from tolman.plugins.testing import ScriptedRobot, Trial, percept
from tolman.world.robot import Percept, WheelCommand

from tools.draw_behaviors import built_in

from .figures import Figure, median_seconds, report

TICKS, TRIAL_TICKS, ROUNDS = 20_000, 50, 9
MOST, MOST_ALONE = 60.0, 50.0
"""Microseconds that the median tick may take; milliseconds of the isolated test of a behavior."""


class _Layer(Behavior):
    """A stand-in that weighs its sensors and always proposes."""

    class States(Enum):
        """Only one."""

        ON = "on"

    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal | None:
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


def tick_figures() -> Iterator[Figure]:
    """Median and 99th percentile of a tick, on a robot that senses a wall on its right."""
    agent = Agent(ScriptedRobot([percept(right=0.022)]), six_behaviors())
    for name in agent.behaviors:
        agent.start(name)
    durations = np.empty(TICKS)
    for tick in range(TICKS):
        start = time.perf_counter()
        agent.tick()
        durations[tick] = time.perf_counter() - start
    what = "tick without physics, six behaviors"
    yield Figure(f"{what}: median", 1e6 * float(np.median(durations)), "us", MOST)
    yield Figure(f"{what}: 99th percentile", 1e6 * float(np.percentile(durations, 99.0)), "us")


def trial_figures() -> Iterator[Figure]:
    """Each built-in behavior alone."""
    run = percepts(TRIAL_TICKS)
    for cls in built_in():
        seconds = median_seconds(partial(_trial, cls, run), ROUNDS)
        yield Figure(f"{cls.name} alone, {TRIAL_TICKS} ticks", 1e3 * seconds, "ms", MOST_ALONE)


def _trial(cls: type[Behavior], run: list[Percept]) -> None:
    Trial(cls(), goal=cls.example).run(run)


def main() -> int:
    """Prints what was measured."""
    missed = report(tick_figures()) + report(trial_figures())
    simulators = [name for name in ("dartpy", "embreex", "matplotlib") if name in sys.modules]
    print(f"simulators loaded: {', '.join(simulators) or 'none'}")
    return 1 if missed or simulators else 0


if __name__ == "__main__":
    sys.exit(main())
