"""Shows how far path integration errs under preset `thesis` after one loop: the calibration of its mismatch.

Run with `python -m benchmarks.calibration [RUNS]`. The robot is taken to follow the loop at 3 cm/s without
error, turning in place at the corners, while its encoders count what its unequal wheels turn, with their own
noise: from the start of each world, by both sides, and from two starts on every wall (fewer runs each).
"""

from __future__ import annotations

import argparse
import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from tolman.world import CONTROL_PERIOD, EPUCK, PRESETS, built_in_world
from tolman.world.starts import BESIDE

from tools.offset_loop import boundary_loops, offset

Floats = NDArray[np.float64]
PUBLISHED = {"env1": 61.0, "env2": 84.0, "env3": 91.0}
"""Mean error (cm) of table 4.3."""
SPEED = 0.03
TURNING = 100.0
"""Steps/s of each wheel while turning in place."""
NOISE = PRESETS["thesis"]


def errors(places: list[Floats], mismatch: Floats, random: np.random.Generator) -> Floats:
    """Distances (runs,) m of the integrated from the true end of a closed way along `places` (m).

    mismatch: (runs,), as in `Noise`.
    """
    x, y, heading = np.zeros(len(mismatch)), np.zeros(len(mismatch)), np.zeros(len(mismatch))
    before: float | None = None
    for start, end in pairwise(places):
        way = end - start
        length, direction = float(np.hypot(*way)), math.atan2(way[1], way[0])
        if length < 1e-9:
            continue
        turn = math.remainder(direction - before, math.tau) if before is not None else 0.0
        heading = heading + direction if before is None else heading
        before = direction
        arc = turn * EPUCK.track / 2
        spent = abs(arc) / (TURNING * EPUCK.distance_per_step)
        for left, right, duration in ((-arc, arc, spent), (length, length, length / SPEED)):
            ticks = math.ceil(duration / CONTROL_PERIOD)
            if ticks:
                counts = random.uniform(-NOISE.encoder, NOISE.encoder, (2, len(mismatch), ticks)) + 1.0
                lefts = left / ticks / (1.0 + mismatch / 2)[:, None] * counts[0]
                rights = right / ticks / (1.0 - mismatch / 2)[:, None] * counts[1]
                headings = heading[:, None] + np.cumsum((rights - lefts) / EPUCK.track, axis=1)
                x = x + ((lefts + rights) / 2 * np.cos(headings)).sum(axis=1)
                y = y + ((lefts + rights) / 2 * np.sin(headings)).sum(axis=1)
                heading = headings[:, -1]
    return np.hypot(x, y)


def way_round(loop: list[Floats], edge: int, share: float, reverse: bool) -> list[Floats]:
    """Once round the corners of a loop, from a share of the way along one edge back to there."""
    count = len(loop)
    start = loop[edge] + share * (loop[(edge + 1) % count] - loop[edge])
    places = [start, *(loop[(edge + 1 + k) % count] for k in range(count)), start]
    return places[::-1] if reverse else places


def nearest(loop: list[Floats], place: Floats) -> tuple[int, float, float]:
    """The edge nearest to a place, the share along it, and how far off (m) it is."""
    found = []
    for edge, (a, b) in enumerate(pairwise([*loop, loop[0]])):
        share = min(max(float((place - a) @ (b - a) / ((b - a) @ (b - a))), 0.0), 1.0)
        found.append((float(np.hypot(*(a + share * (b - a) - place))), edge, share))
    off, edge, share = min(found)
    return edge, share, off


def calibrate(world: str, runs: int, random: np.random.Generator) -> tuple[float, list[float]]:
    """Mean error (cm) from the world's start, and from two starts on every edge of its loop."""
    spec = built_in_world(world)
    pose = spec.starts[0].pose
    start = np.array((pose.x, pose.y))
    loops = [[np.array(point) for point in offset(loop, BESIDE)] for loop in boundary_loops(spec)]
    loop = min(loops, key=lambda loop: nearest(loop, start)[2])
    edge, share, _ = nearest(loop, start)

    def mean(edge: int, share: float, reverse: bool, runs: int) -> float:
        mismatch = random.uniform(-NOISE.mismatch, NOISE.mismatch, runs)
        return 100.0 * float(errors(way_round(loop, edge, share, reverse), mismatch, random).mean())

    own = (mean(edge, share, False, runs) + mean(edge, share, True, runs)) / 2
    few = max(10, runs // 5)
    others = [mean(k, part, False, few) for k in range(len(loop)) for part in (0.25, 0.75)]
    return own, others


def main() -> None:
    """Prints one line a world."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    means = []
    for world, published in PUBLISHED.items():
        own, others = calibrate(world, options.runs, random)
        means.append(own)
        print(
            f"{world}: {own:.0f} cm, published {published:.0f} ({100 * (own / published - 1):+.0f} %); "
            f"from starts anywhere {min(others):.0f} to {max(others):.0f}, mean {np.mean(others):.0f}"
        )
    target = float(np.mean(list(PUBLISHED.values())))
    mean = float(np.mean(means))
    print(f"mean of the three: {mean:.0f} cm, published {target:.0f} ({100 * (mean / target - 1):+.0f} %)")


if __name__ == "__main__":
    main()
