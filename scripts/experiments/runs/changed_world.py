"""One trip of an experiment in a world that has changed since it was mapped.

A job's settings name the mapping (keys `map ...`, as for traversals), a `seed` and a `change`: "added" (a box
at a wall), "removed", "moved" (a box of the world), "shut" (a passage).
`run_changed_world(settings, folder) -> dict` draws the change, the node the robot starts at and the one it is
sent to. Result:

    outcome            "arrived" (within 15 cm of the node), "false" (says so, but is elsewhere), "gave up"
    reason             what the trip said
    attempts           ways tried
    touched            whether the change lies on the way planned first
    error_m            from the true place of the node (m); a node at a box that was moved moved with it
    shape              the box that was added, or moved to, or removed: x, y, width, depth (m)
    start, goal        nodes
    collisions, sim_time_s, distance_m
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....agent.walls import WALL_DISTANCE
from ....maps.hybrid_map import HybridMap
from ....world.arenas.catalog import find_world
from ....world.geometry import Plan
from ....world.robot import EPUCK, Pose
from ....world.spec import Box, Shape, WorldSpec
from ...session.simulation import Simulation
from ...session.trip import Trip
from ..campaign.jobs import CHANGES
from .over_map import LOST_BEYOND, mapped_for, read_map, simulated_as

Poses = Mapping[int, Pose]
"""True poses of nodes (m, rad, world frame)."""
_OUTSIDE = 4
"""The first shapes of a world are the walls around it."""
_AT_A_BOX = 0.09
"""A node nearer (m) to a box is at one of its corners: followed at 5.7 cm, they are 8 cm away at most."""
_TRIES = 2000


def run_changed_world(settings: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Changes the world of a map and sends the robot somewhere; lengths in m."""
    return drive_in_changed_world(mapped_for(settings, folder), settings)


def drive_in_changed_world(path: Path, settings: Mapping[str, Any]) -> dict[str, Any]:
    """The same on a map file. Settings: seed, change, and of the map world, profile, noise, noise_scale."""
    hybrid_map, truth = read_map(path)
    rng = np.random.default_rng(np.random.SeedSequence([int(settings["seed"]), 11]))
    spec = find_world(str(settings["map world"]))
    changed, shape = change_world(spec, str(settings["change"]), hybrid_map, truth, rng)
    start, goal = _two_nodes(Plan(changed.shapes), truth, hybrid_map.nodes(), rng)
    touched = _touches(hybrid_map, truth, start, goal, shape)
    with Simulation(changed, simulated_as(settings), start=truth[start]) as simulation:
        trip = Trip(simulation, hybrid_map, goal)
        report = trip.drive(start, None, truth)
        places = places_now(truth[goal], spec, changed)
        error = min(place.distance_to(simulation.world.true_pose()) for place in places)
    assert trip.guide is not None  # it is told where it starts
    arrived = error <= LOST_BEYOND
    return {
        "outcome": ("arrived" if arrived else "false") if report.reached else "gave up",
        "reason": report.reason,
        "attempts": trip.guide.attempts,
        "touched": touched,
        "error_m": error,
        "shape": [shape.x, shape.y, shape.width, shape.depth],
        "start": start,
        "goal": goal,
        "collisions": report.collisions,
        "sim_time_s": report.sim_time_s,
        "distance_m": report.distance_m,
    }


def change_world(
    spec: WorldSpec, change: str, hybrid_map: HybridMap, truth: Poses, rng: np.random.Generator
) -> tuple[WorldSpec, Box]:
    """A world that differs by one box, and that box. Raises: ValueError for what cannot be done."""
    boxes = [index for index, shape in enumerate(spec.shapes) if index >= _OUTSIDE and isinstance(shape, Box)]
    shapes: list[Shape] = list(spec.shapes)
    if change in ("removed", "moved"):
        index = int(rng.choice(boxes))
        box = shapes[index]
        assert isinstance(box, Box)
        if change == "removed":
            del shapes[index]
            return replace(spec, shapes=tuple(shapes)), box
        shift = float(rng.uniform(0.05, 0.15)) * float(rng.choice((-1.0, 1.0)))
        moved = replace(box, x=box.x + shift) if rng.uniform() < 0.5 else replace(box, y=box.y + shift)
        shapes[index] = moved
        return replace(spec, shapes=tuple(shapes)), moved
    if change not in ("added", "shut"):
        raise ValueError(f"unknown change {change!r}; known: {', '.join(CHANGES)}")
    added = _added(spec, change, hybrid_map, truth, rng)
    return replace(spec, shapes=(*shapes, added)), added


def places_now(place: Pose, spec: WorldSpec, changed: WorldSpec) -> list[Pose]:
    """Where a node may be in a changed world: where it was and, at a box that was moved, as far from that."""
    found = [place]
    if len(changed.shapes) != len(spec.shapes):
        return found
    for before, after in zip(spec.shapes, changed.shapes, strict=True):
        if not isinstance(before, Box) or not isinstance(after, Box) or before == after:
            continue
        if Plan((before,)).clearance(place.x, place.y) < _AT_A_BOX:
            found.append(Pose(place.x + after.x - before.x, place.y + after.y - before.y, place.heading))
    return found


def _added(
    spec: WorldSpec, change: str, hybrid_map: HybridMap, truth: Poses, rng: np.random.Generator
) -> Box:
    """A box at a wall beside the way; one that shuts a passage reaches to the wall across."""
    plan, side = Plan(spec.shapes), hybrid_map.meta.side
    arcs = [arc for arc in hybrid_map.arcs() if arc.kind == side and arc.distance > 0.2]
    for _ in range(_TRIES):
        arc = arcs[int(rng.integers(len(arcs)))]
        one, other = truth[arc.start], truth[arc.end]
        share = float(rng.uniform(0.3, 0.7))
        heading = math.atan2(other.y - one.y, other.x - one.x)
        place = Pose(one.x + share * (other.x - one.x), one.y + share * (other.y - one.y), heading)
        toward = -1.0 if side == "right" else 1.0
        across = _room(plan, place.compose(0.0, 0.0, -toward * 0.5 * math.pi))
        width = float(rng.uniform(0.06, 0.14))
        if change == "added":
            depth = float(rng.uniform(0.05, 0.14))
        elif across < 0.45:
            depth = across + WALL_DISTANCE
        else:
            continue
        middle = place.compose(0.0, toward * (WALL_DISTANCE - 0.5 * depth))
        return Box(middle.x, middle.y, width, depth, heading)
    raise ValueError(f"no passage to shut in {spec.name!r}")


def _room(plan: Plan, pose: Pose) -> float:
    """How far (m) it is straight ahead to something solid, in steps of 5 mm, 2 m at most."""
    for step in range(400):
        ahead = pose.compose(0.005 * step, 0.0)
        if plan.contains(ahead.x, ahead.y):
            return 0.005 * step
    return 2.0


def _two_nodes(plan: Plan, truth: Poses, nodes: list[int], rng: np.random.Generator) -> tuple[int, int]:
    """Where the robot starts, with room around it, and another node, whatever has become of it."""

    def is_free(pose: Pose) -> bool:
        x, y = pose.x, pose.y
        return plan.clearance(x, y) > EPUCK.body_radius + 0.005 and not plan.contains(x, y)

    start = int(rng.choice([node for node in nodes if is_free(truth[node])]))
    return start, int(rng.choice([node for node in nodes if node != start]))


def _touches(hybrid_map: HybridMap, truth: Poses, start: int, goal: int, box: Box) -> bool:
    """Whether the box is within 15 cm of the way that is planned first."""
    plan = Plan((box,))
    for arc in hybrid_map.path(start, goal):
        one, other = truth[arc.start], truth[arc.end]
        for share in np.linspace(0.0, 1.0, 20):
            x, y = one.x + share * (other.x - one.x), one.y + share * (other.y - one.y)
            if plan.contains(x, y) or plan.clearance(x, y) < 0.15:
                return True
    return False
