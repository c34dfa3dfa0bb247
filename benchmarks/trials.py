"""Measures what testing a behavior alone costs: made, started, and asked for fifty ticks, without an agent.

Run with `python -m benchmarks.trials`. Prints a line for each built-in behavior; the exit status is
1 if one takes more than 50 ms (median of nine), or if a simulator was loaded.
"""

from __future__ import annotations

import statistics
import sys
import time

from tolman.agent.behavior import Behavior
from tolman.plugins.check import example_goal, percepts
from tolman.plugins.testing import Trial

from tools.draw_behaviors import built_in

MOST = 0.050
"""Seconds that the isolated test of a behavior may take."""
TICKS, ROUNDS = 50, 9


def measure(cls: type[Behavior]) -> float:
    """Median seconds of a trial of the behavior."""
    run, durations = percepts(TICKS), []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        Trial(cls(), goal=example_goal(cls)).run(run)
        durations.append(time.perf_counter() - start)
    return statistics.median(durations)


def main() -> int:
    """Prints what was measured."""
    slow = 0
    for cls in built_in():
        duration = measure(cls)
        slow += duration > MOST
        print(f"{cls.name:<24} {duration * 1e3:6.1f} ms")
    simulators = [name for name in ("dartpy", "embreex", "matplotlib") if name in sys.modules]
    print(f"{slow} take more than {MOST * 1e3:.0f} ms; simulators loaded: {', '.join(simulators) or 'none'}")
    return 1 if slow or simulators else 0


if __name__ == "__main__":
    sys.exit(main())
