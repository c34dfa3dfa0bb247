"""One unknown start of an experiment: a robot dropped somewhere on a map finds out where it is.

A job's settings name the mapping (keys `map ...`, as for traversals), a `seed` that draws the start, and
where it is dropped. `run_unknown_start(settings, folder) -> dict` maps if the folder has no such map yet.
Result:

    outcome            "right", "wrong" (claims a node it is more than 15 cm from), "ambiguous", "not found"
    reason             what the robot said
    after_m, share     driven along the boundary until the claim (m), and that by the length of the loop;
                       None without a claim
    loop_m             length of the loop (m)
    error_m            from where it claimed to stand (m), None without a claim
    start              where it was dropped: x, y (m), heading (rad), world frame
    collisions, sim_time_s
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....agent.events import Stuck
from ....agent.localization.localizer import Localizer
from ....agent.navigation.recovery import PATIENCE, TIME_PER_METER
from ....world.arenas.catalog import find_world
from ....world.geometry import Plan
from ....world.robot import EPUCK, Pose
from ....world.starts import is_walled_in
from ...session.simulation import Simulation
from .over_map import LOST_BEYOND, mapped_for, read_map, simulated_as

DISTANCES: Mapping[str, tuple[float, float]] = {"wall": (0.04, 0.10), "open": (0.10, math.inf)}
"""Where a robot is dropped: least and most distance (m) of its center from the nearest wall."""
_TRIES = 100_000


def run_unknown_start(settings: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Drops a robot somewhere and lets it find out where it is; lengths in m, angles in rad."""
    return find_place(mapped_for(settings, folder), settings)


def find_place(path: Path, settings: Mapping[str, Any]) -> dict[str, Any]:
    """The same on a map file. Settings: seed, drop, and of the map world, profile, noise, noise_scale."""
    hybrid_map, truth = read_map(path)
    spec = find_world(str(settings["map world"]))
    start = drop_pose(Plan(spec.shapes), str(settings["drop"]), int(settings["seed"]))
    with Simulation(spec, simulated_as(settings), start=start) as simulation:
        localizer = Localizer(simulation.agent, hybrid_map)
        _drive(simulation, localizer)
        found, loop = localizer.node is not None, localizer.filter.loop_length
        error = None
        if localizer.node is not None:
            error = truth[localizer.node].distance_to(simulation.world.true_pose())
        return {
            "outcome": _outcome(localizer, error),
            "reason": localizer.reason,
            "node": localizer.node,
            "after_m": localizer.length if found else None,
            "share": localizer.length / loop if found else None,
            "loop_m": loop,
            "error_m": error,
            "start": [start.x, start.y, start.heading],
            "collisions": simulation.world.collisions(),
            "sim_time_s": simulation.time,
        }


def _drive(simulation: Simulation, localizer: Localizer) -> None:
    """Drives along the boundary until the robot knows where it is, or gives up."""
    stuck: list[Stuck] = []
    simulation.agent.bus.subscribe(Stuck, stuck.append)
    localizer.start()
    limit = PATIENCE + 3.0 * TIME_PER_METER * localizer.filter.loop_length
    simulation.run(lambda: localizer.done or any(event.given_up for event in stuck), limit=limit)


def _outcome(localizer: Localizer, error: float | None) -> str:
    if error is not None:
        return "right" if error <= LOST_BEYOND else "wrong"
    return "ambiguous" if localizer.reason.startswith("ambiguous") else "not found"


def drop_pose(plan: Plan, drop: str, seed: int) -> Pose:
    """A pose inside a room at a distance from its walls as `drop` says, each place equally likely.

    Raises: ValueError if there seems to be no such place.
    """
    nearest, farthest = DISTANCES[drop]
    rng = np.random.default_rng(np.random.SeedSequence([seed, sorted(DISTANCES).index(drop)]))
    x0, y0, x1, y1 = plan.bounds
    for _ in range(_TRIES):
        x, y, heading = rng.uniform((x0, y0, -math.pi), (x1, y1, math.pi))
        if nearest <= plan.clearance(x, y) <= farthest and _inside(plan, x, y):
            return Pose(float(x), float(y), float(heading))
    raise ValueError(f"no place to drop a robot {nearest:g} to {farthest:g} m from the walls")


def _inside(plan: Plan, x: float, y: float) -> bool:
    """Whether there are walls all around and nothing overlaps the robot."""
    overlaps = plan.contains(x, y) or plan.clearance(x, y) < EPUCK.body_radius
    return not overlaps and is_walled_in(plan, x, y)
