"""Measures a robot behind a link: infrared baselines, sensors' gains by a wall, the track by whole turns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import SimulationError
from ..robot import STOP, Robot, WheelCommand
from .calibration import Calibration
from .driver import LinkedWorld

RESTING = 60
"""Ticks over which a baseline is the mean."""
SPEED = 150.0
"""Steps/s of the wheels in turns on the spot."""
TURNS = 6.0
"""Turns on the spot, by the published track."""
DIM = 60.0
"""Counts above the lowest below which a wall is not seen well enough to measure by."""
NEAR = 80.0
"""Counts at rest that no baseline gives: something is near."""
LEAST, MOST = 0.7, 1.4
"""Shares of the published track that are looked for."""
FLOOR = 10.0
"""Counts of the published response with nothing in range."""


def measure_offsets(world: LinkedWorld, before: Calibration) -> Calibration:
    """Baselines: the robot rests, and nothing is within 10 cm of it.

    Raises: SimulationError (a run that failed) when something is.
    """
    means = np.mean(_at_rest(world), axis=0)
    near = [index for index, mean in enumerate(means) if mean > NEAR]
    if near:
        shown = ", ".join(map(str, near))
        raise SimulationError(f"something is near infrared sensor {shown}: clear 10 cm all around it")
    return replace(before, offsets=tuple(float(each) - FLOOR for each in means))


def measure_by_wall(
    world: LinkedWorld, before: Calibration, tell: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Gains and track: it turns on the spot, 1 to 3 cm from a wall, with nothing else within 10 cm.

    Every sensor passes the wall at the same distance, so their highest values compare their gains. What is
    seen comes again after one true turn. tell: is told the share that is done.

    Raises: SimulationError (a run that failed) when no wall is seen well enough.
    """
    turned, values = _turns(world, tell)
    lit = values - np.array(before.offsets)
    if float(lit.max(axis=0).min()) < lit.min() + DIM:
        raise SimulationError(
            "no wall is near enough for every sensor: put the robot 1 to 3 cm from one wall"
        )
    peaks = np.array([np.sort(column)[-max(3, len(column) // 60) :].mean() - FLOOR for column in lit.T])
    gains = tuple(float(peak / peaks.mean()) for peak in peaks)
    return replace(before, gains=gains, track=_period(turned, lit) / math.tau)


def _at_rest(world: LinkedWorld) -> NDArray[np.float64]:
    robot = world.robots[0]
    robot.act(STOP)
    rows = []
    for _ in range(RESTING):
        world.step()
        rows.append(robot.sense().infrared)
    return np.array(rows)


def _turns(
    world: LinkedWorld, tell: Callable[[float], None]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Turns on the spot: angles by the published track (rad), and what was sensed there."""
    robot = world.robots[0]
    first = _angle(robot, robot.sense().encoders)
    angles: list[float] = []
    rows: list[Sequence[float]] = []
    angle = 0.0
    while angle < TURNS * math.tau:
        robot.act(WheelCommand(-SPEED, SPEED))
        world.step()
        percept = robot.sense()
        angle = _angle(robot, percept.encoders) - first
        angles.append(angle)
        rows.append(percept.infrared)
        tell(angle / (TURNS * math.tau))
    robot.act(STOP)
    world.step()
    return np.array(angles), np.array(rows)


def _angle(robot: Robot, encoders: tuple[float, float]) -> float:
    return (encoders[1] - encoders[0]) * robot.geometry.radians_per_step


def _period(angles: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """The angle (rad, by the published track) after which all sensors see the same again.

    By the best match of what was seen with itself some turns later, first roughly with one turn, then finely
    with as many as there are.
    """
    grid = np.arange(0.0, angles[-1], math.radians(0.5))
    seen = np.stack([np.interp(grid, angles, column) for column in values.T], axis=1)
    seen = (seen - seen.mean(axis=0)) / (seen.std(axis=0) + 1e-9)
    best, turns = math.tau, 1
    low, high = LEAST * math.tau, MOST * math.tau
    while True:
        lags = np.arange(int(low * turns / grid[1]), int(high * turns / grid[1]) + 1)
        lags = lags[(lags > 0) & (lags < len(grid) - 60)]
        if not len(lags):
            return best
        scores = np.array([float((seen[lag:] * seen[:-lag]).mean()) for lag in lags])
        at = int(scores.argmax())
        best = float((lags[at] + _top(scores, at)) * grid[1]) / turns
        turns += 1
        if best * turns > grid[-1] - math.pi:
            return best
        low, high = best * (1.0 - 0.1 / turns), best * (1.0 + 0.1 / turns)


def _top(scores: NDArray[np.float64], at: int) -> float:
    """Where between samples the maximum at `at` is, by a parabola: -0.5 to 0.5."""
    if not 0 < at < len(scores) - 1:
        return 0.0
    before, here, after = scores[at - 1 : at + 2]
    bend = before - 2.0 * here + after
    return 0.0 if bend == 0.0 else max(-0.5, min(0.5, 0.5 * (before - after) / bend))
