"""Study `beyond`: starts that the robot is not told, changed worlds, obstacles that stand free."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..campaign.campaign import Job, Result
from ..campaign.running import SIDES, seeds
from ..campaign.summary import markdown_table, summarize
from ..report.scores import closing
from ..runs.beyond import DROPS, unknown_start_job
from ..runs.changes import CHANGES, changed_world_job
from ..runs.mapping import mapping_job
from .study import Asked, Groups, Results, Study, finished

RUNS = 20
"""Starts an environment and way of dropping, where not asked otherwise; a quarter of trips a change."""
AMBIGUOUS = "symmetric"
"""A room that looks the same after a quarter turn: nothing in it tells where the robot is."""
PATTERNED = "symmetric-textured"
"""The same room with a pattern on every wall: views alone tell where the robot is."""
ISLANDS, OBSTACLES = "islands", 4
"""A world with free-standing obstacles, and how many it has."""
HALF_A_LOOP = 0.5


def _maps(world: str, asked: Asked) -> list[Job]:
    """One map a side; without local maps where the boundary tells places, so that views cannot help it."""
    views = world in (AMBIGUOUS, PATTERNED)
    return [
        mapping_job(world, side, asked.first_seed + k, "default", local_maps=views)
        for k, side in enumerate(SIDES)
    ]


def _start_worlds(asked: Asked) -> tuple[str, ...]:
    return (*asked.environments, PATTERNED, AMBIGUOUS)


def _islands(asked: Asked) -> list[Job]:
    """Mappings that look for free-standing obstacles."""
    runs = max(1, (asked.runs or RUNS) // 5)
    return [
        mapping_job(ISLANDS, side, seed, "default", local_maps=False, islands=True)
        for seed, side in seeds(asked.first_seed, runs)
    ]


def _mappings(asked: Asked, results: Results) -> Groups:
    maps = {world: _maps(world, asked) for world in _start_worlds(asked)}
    return {**maps, ISLANDS: _islands(asked)}


def _starts(world: str, drop: str, asked: Asked, results: Results) -> list[Job]:
    maps = [job for job, result in finished(_maps(world, asked), results) if result["finished"]]
    runs = asked.runs or RUNS
    return [unknown_start_job(maps[k % len(maps)], asked.first_seed + k, drop) for k in range(runs) if maps]


def _changes(world: str, change: str, asked: Asked, results: Results) -> list[Job]:
    maps = [job for job, result in finished(_maps(world, asked), results) if result["finished"]]
    runs = max(1, (asked.runs or RUNS) // 4)
    return [changed_world_job(maps[k % len(maps)], asked.first_seed + k, change) for k in range(runs) if maps]


def _trips(asked: Asked, results: Results) -> Groups:
    groups: dict[str, list[Job]] = {
        f"{world}, {drop}": _starts(world, drop, asked, results)
        for world in _start_worlds(asked)
        for drop in DROPS
    }
    return groups | {
        f"{world}, {change}": _changes(world, change, asked, results)
        for world in asked.environments
        for change in CHANGES
    }


def _count(found: Sequence[Result], outcome: str) -> str:
    return str(sum(result["outcome"] == outcome for result in found))


def _unknown_starts(asked: Asked, results: Results) -> str:
    outcomes = ("right", "ambiguous", "not found", "wrong")
    header = [
        "world",
        "dropped",
        "starts",
        *outcomes,
        "share of a loop, mean (worst)",
        "error (cm), mean (worst)",
    ]
    lines, right, total, wrong = [], 0, 0, 0
    for world in _start_worlds(asked):
        for drop in DROPS:
            found = [result for _, result in finished(_starts(world, drop, asked, results), results)]
            claims = [result for result in found if result["share"] is not None]
            wrong += sum(result["outcome"] == "wrong" for result in found)
            if world != AMBIGUOUS:
                total += len(found)
                right += sum(
                    result["outcome"] == "right" and result["share"] <= HALF_A_LOOP for result in found
                )
            lines.append(
                [
                    world,
                    drop,
                    str(len(found)),
                    *(_count(found, outcome) for outcome in outcomes),
                    _spread([float(result["share"]) for result in claims]),
                    _spread([100.0 * float(result["error_m"]) for result in claims]),
                ]
            )
    verdict = (
        f"Right within half a loop: **{right} of {total}** (target 49 of 50); false claims in all: "
        f"**{wrong}** (target none in 200). In `{PATTERNED}` views alone tell places apart "
        f"(its maps, and those of `{AMBIGUOUS}`, have local maps); in `{AMBIGUOUS}` "
        "nothing does: *ambiguous* is right there."
    )
    return f"{verdict}\n\n{markdown_table(header, lines)}"


def _changed_worlds(asked: Asked, results: Results) -> str:
    outcomes = ("arrived", "gave up", "false")
    header = [
        "world",
        "change",
        "trips",
        "on the way",
        *outcomes,
        "error where it arrived (cm), mean (worst)",
    ]
    lines = []
    for world in asked.environments:
        for change in CHANGES:
            found = [result for _, result in finished(_changes(world, change, asked, results), results)]
            there = [100.0 * float(result["error_m"]) for result in found if result["outcome"] == "arrived"]
            touched = sum(bool(result["touched"]) for result in found)
            counts = (_count(found, outcome) for outcome in outcomes)
            lines.append([world, change, str(len(found)), str(touched), *counts, _spread(there)])
    return markdown_table(header, lines)


def _free_standing(asked: Asked, results: Results) -> str:
    header = ["seed", "side", "found", "forays", "closed", "nodes", "collisions", "simulated s", "reason"]
    lines = [
        [
            str(job.settings["seed"]),
            str(job.settings["side"]),
            f"{result.get('islands')} of {OBSTACLES}",
            str(result.get("forays")),
            closing(result),
            str(result["nodes"]),
            str(result["collisions"]),
            f"{result['sim_time_s']:.0f}",
            str(result["reason"]),
        ]
        for job, result in finished(_islands(asked), results)
    ]
    return markdown_table(header, lines) if lines else "none"


def _spread(values: Sequence[float]) -> str:
    found = summarize(list(values))
    return "none" if found is None else f"{found.mean:.2f} ({found.greatest:.2f})"


def _report(asked: Asked, results: Results) -> str:
    return "\n\n".join(
        [
            "### Unknown start\n\nDropped somewhere with any heading, at a wall (4 to 10 cm from it) or "
            "in the open (farther), on a map of either side: the robot drives until it claims to be at a "
            "node, or says why not.",
            _unknown_starts(asked, results),
            "### A changed world\n\nA box is added, removed or moved, or a passage shut, after the "
            "mapping; then a trip between two nodes. *On the way*: the change lies on the way planned "
            "first. *Gave up*: with a reason. *False*: it says that it is there, and is not.",
            _changed_worlds(asked, results),
            f"### Free-standing obstacles\n\nWorld `{ISLANDS}`, mapped without local maps, looking for "
            f"obstacles that no round along the outer wall meets: {OBSTACLES} stand free. *Closed*: every "
            "loop where it truly is.",
            _free_standing(asked, results),
        ]
    )


def _values(asked: Asked, results: Results) -> Any:
    return {
        "islands": [result for _, result in finished(_islands(asked), results)],
        "unknown start": {
            f"{world}, {drop}": [
                result for _, result in finished(_starts(world, drop, asked, results), results)
            ]
            for world in _start_worlds(asked)
            for drop in DROPS
        },
        "changed world": {
            f"{world}, {change}": [
                result for _, result in finished(_changes(world, change, asked, results), results)
            ]
            for world in asked.environments
            for change in CHANGES
        },
    }


BEYOND = Study(
    "beyond", "Unknown starts, changed worlds, free-standing obstacles", (_mappings, _trips), _report, _values
)
